"""A small sea with directions, for tests of what the app does with them."""

SEA = """
title = "A bare sea"
seed = 1
bounds = { radius_cm = 900.0, depth_cm = 500.0 }
water = { fog = [0.006, 0.072, 0.180], visibility_cm = 1500.0 }
terrain = { dune_height_cm = 30.0, dune_length_cm = 600.0 }
submarine = { position_cm = [-480.0, -60.0, -250.0] }
nature = { submarine_cm = 0.0, curiosity_cm = 0.0 }
[[fish]]
species = "fusilier"
number = 4
position_cm = [-300.0, 0.0, -250.0]
spread_cm = 50.0
heading_deg = 90.0
[[fish]]
species = "clownfish"
number = 2
position_cm = [-300.0, 200.0, -250.0]
spread_cm = 30.0
[[rock]]
position_cm = [100.0, 0.0]
size_cm = [120.0, 150.0, 320.0]
[[tour]]
name = "glide"
waypoint = [
    { time_s = 0.0, position_cm = [300.0, -300.0, -250.0], ahead = true },
    { time_s = 4.0, position_cm = [300.0, -100.0, -250.0] },
]
"""


def scene(folder, *directions):
    """The file of the bare sea with these `[[direction]]`."""
    file = folder / "scene.toml"
    file.write_text(SEA + "".join(f"[[direction]]\n{one}\n" for one in directions))
    return file
