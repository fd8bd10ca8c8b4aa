"""Install commands for missing system libraries, as in `tools/setup.sh`."""

HEADLESS = "libegl1 libgl1 libgl1-mesa-dri"
WINDOW = "libx11-6 libxext6 libxcursor1 libxi6 libxinerama1 libxrandr2 libxkbcommon0"
INSTALL = f"sudo apt-get install --no-install-recommends {HEADLESS} {WINDOW}"
