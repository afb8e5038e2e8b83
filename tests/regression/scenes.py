"""The tables with which the scenes of these tests begin, as text."""


def tank(size, *blocks, dt="0.016666666666666667", end="1.0", domain="", more="[gravity]\n"):
    """A box from the origin to `size`, with blocks (min, max, more keys) of water; corners are texts, "0, 0, 0"."""
    lines = ["[domain]", "min = [0, 0, 0]", f"max = [{size}]", domain, "[fluid]", "spacing = 0.1"]
    for low, high, *keys in blocks:
        lines += ["[[particles]]", f"min = [{low}]", f"max = [{high}]", *keys]
    return "\n".join(line for line in [*lines, "[time]", f"dt = {dt}", f"end = {end}"] if line) + "\n" + more
