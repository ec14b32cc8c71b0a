"""Recordings of `palpate-link` and `hil`, read by packages that are not ours: mcap for the file, protobuf for its messages."""

import math


def messages(path):
    """(topic, time in seconds of the recording's clock, message) of every message; facts come first, as topic None."""
    # Here, since the virtual lab has Python's own library alone.
    from google.protobuf import descriptor_pb2, message_factory
    from mcap.reader import make_reader

    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        yield None, 0.0, {m.name: m.metadata for m in reader.iter_metadata()}
        classes = {}
        for schema, channel, message in reader.iter_messages():
            if schema.id not in classes:
                files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
                classes[schema.id] = message_factory.GetMessages(files.file)[schema.name]
            yield channel.topic, message.log_time / 1e9, classes[schema.id].FromString(message.data)


class Recording:
    """Where the skin was touched, and where that was felt, mm; times in seconds of the recording's clock."""

    def __init__(self, path):
        self.truth, self.felt, self.aims = [], [], []
        for topic, at, message in messages(path):
            if topic == "/truth":
                self.truth.append((at, message.x_mm, message.y_mm))
            elif topic == "/felt" and message.inside:
                self.felt.append((at, message.energy_x_mm, message.energy_y_mm))
                self.aims.append((at, message.target_x_mm, message.target_y_mm))

    def touched(self, at):
        """Where, between the two frames around a time; None where one of them is further than 50 ms away."""
        after = next((k for k, t in enumerate(self.truth) if t[0] >= at), None)
        if not after:
            return None
        (t0, x0, y0), (t1, x1, y1) = self.truth[after - 1], self.truth[after]
        if at - t0 > 0.05 or t1 - at > 0.05:
            return None
        share = (at - t0) / (t1 - t0) if t1 > t0 else 0.0
        return x0 + share * (x1 - x0), y0 + share * (y1 - y0)


def scale_of(wired):
    """How many mm of the display one of the skin is, along both axes: aims of a wired run are its true places, mapped."""
    pairs = [(aim, wired.touched(aim[0])) for aim in wired.aims]
    pairs = [(aim[1:], place) for aim, place in pairs if place]
    most = max(pairs, key=lambda pair: math.hypot(*pair[1]))
    axis = 0 if abs(most[1][0]) >= abs(most[1][1]) else 1
    scale = most[0][axis] / most[1][axis]
    worst = max(math.hypot(a[0] - scale * p[0], a[1] - scale * p[1]) for a, p in pairs)
    assert worst < 0.05, f"the map from skin to display is no scale: {worst} mm"
    return scale


def felt_error(wearer, robot, ahead_s, scale):
    """RMSE, mm, of what was felt against where the robot was touched at that moment; `ahead_s` is the wearer's clock minus the
    robot's. And how many onsets that is of."""
    squares = []
    for at, x, y in wearer.felt:
        place = robot.touched(at - ahead_s)
        if place:
            squares.append((x - scale * place[0]) ** 2 + (y - scale * place[1]) ** 2)
    return math.sqrt(sum(squares) / len(squares)), len(squares)
