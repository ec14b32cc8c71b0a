"""Warm clustering by libraries from PyPI, one thread, on frames from standard input.

In: a JSON list of frames {x, y, w, start}; start is the last frame's centroids. Out: a JSON list of
{method, median_us, centroids of every frame}. Two iterations where a library lets us say so, weights where it takes
them. Conversion of the frames is not timed.
"""

import json
import statistics
import sys
import time
import warnings

import cv2
import faiss
import numpy as np
from scipy.cluster.vq import kmeans2
from sklearn.cluster import KMeans

warnings.filterwarnings("ignore")
cv2.setNumThreads(1)
faiss.omp_set_num_threads(1)

ITERATIONS = 2
ROUNDS = 3


def sklearn(p, w, start):
    return KMeans(len(start), init=start, n_init=1, max_iter=ITERATIONS).fit(p, sample_weight=w).cluster_centers_


def scipy(p, w, start):
    return kmeans2(p, start, iter=ITERATIONS, minit="matrix")[0]


def faiss_(p, w, start):
    k = faiss.Kmeans(2, len(start), niter=ITERATIONS, min_points_per_centroid=1, max_points_per_centroid=1 << 20)
    k.train(p, weights=w, init_centroids=start)
    return k.centroids


def opencv(p, w, start):
    labels = ((p[:, None, :] - start[None]) ** 2).sum(2).argmin(1).astype(np.int32)
    stop = (cv2.TERM_CRITERIA_MAX_ITER, ITERATIONS, 0)
    begun = time.perf_counter()
    _, _, centroids = cv2.kmeans(p, len(start), labels, stop, 1, cv2.KMEANS_USE_INITIAL_LABELS)
    return centroids, time.perf_counter() - begun


def main():
    frames = [
        (
            np.ascontiguousarray(np.column_stack([f["x"], f["y"]]), dtype=np.float32),
            np.asarray(f["w"], dtype=np.float32),
            np.asarray(f["start"], dtype=np.float32),
        )
        for f in json.load(sys.stdin)
    ]
    answers = []
    for name, method in [("scikit-learn", sklearn), ("scipy", scipy), ("faiss", faiss_), ("OpenCV", opencv)]:
        times, centroids = [], []
        for _ in range(ROUNDS):
            centroids = []
            for frame in frames:
                begun = time.perf_counter()
                found = method(*frame)
                spent = time.perf_counter() - begun
                if isinstance(found, tuple):
                    found, spent = found
                times.append(spent * 1e6)
                centroids.append([[float(x), float(y)] for x, y in found])
        answers.append({"method": name, "median_us": statistics.median(times), "centroids": centroids})
    json.dump(answers, sys.stdout)


main()
