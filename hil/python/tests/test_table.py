"""Tables go on to pandas, polars and Arrow."""

from __future__ import annotations

import numpy as np
import pytest

import palpate


@pytest.fixture(scope="module")
def stimuli() -> palpate.Table:
    return palpate.run("sphere-along").stimuli


def test_a_table_is_an_array_of_numpy(stimuli: palpate.Table) -> None:
    assert isinstance(stimuli, np.ndarray)
    assert type(stimuli["width"]) is np.ndarray
    some = stimuli[stimuli["wire"] == 3]
    assert isinstance(some, palpate.Table) and 0 < len(some) < len(stimuli)
    with pytest.raises(ValueError, match="read-only"):
        stimuli["width"][0] = 1
    stimuli.copy()["width"][0] = 1


def test_pandas(stimuli: palpate.Table) -> None:
    pytest.importorskip("pandas")
    frame = stimuli.to_pandas()
    assert list(frame.columns) == list(stimuli.columns)
    assert (frame["until_us"].to_numpy() == stimuli["until_us"]).all()
    assert set(frame["reason"]) == set(stimuli["reason"])


def test_polars(stimuli: palpate.Table) -> None:
    pytest.importorskip("polars")
    frame = stimuli.to_polars()
    assert frame["width"].sum() == int(stimuli["width"].sum())


def test_arrow(stimuli: palpate.Table) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    felt = palpate.run("sphere-along").felt
    for source in (stimuli, felt, stimuli[:0], stimuli[::2]):
        found = pyarrow.RecordBatchReader.from_stream(source).read_all()
        assert found.column_names == list(source.columns)
        assert found.num_rows == len(source)
        for name in source.columns:
            values = found[name].to_numpy(zero_copy_only=False)
            expected = np.asarray(source[name])
            if expected.dtype.kind == "f":
                np.testing.assert_array_equal(values, expected)
            else:
                assert (values == expected).all(), name
