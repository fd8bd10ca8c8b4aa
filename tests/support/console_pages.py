"""Checks of what all pages of the console have in common, in a browser."""

import time

# Contrast of text with the first opaque ground behind it, by WCAG 2.
CONTRASTS = """(() => {
  const parts = text => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(v => v / 255)
    .map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = one => {
    for (; one; one = one.parentElement) {
      const rgb = parts(getComputedStyle(one).backgroundColor);
      if (rgb.length < 4 || rgb[3] > 0) return rgb;
    }
    return [255, 255, 255];
  };
  return [...document.querySelectorAll("body *")]
    .filter(one => one.offsetParent && !one.disabled
      && [...one.childNodes].some(child => child.nodeType === 3 && child.data.trim()))
    .map(one => {
      const [a, b] = [light(parts(getComputedStyle(one).color)), light(ground(one))];
      return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), one.id || one.textContent.trim()];
    }).filter(([ratio]) => ratio < 4.5);
})()"""
CONTROLS = {"button", "combobox", "textbox", "slider", "checkbox", "spinbutton"}


def click(page, name):
    """Click the element of an ID."""
    page.run(f"document.getElementById({name!r}).click()")


def taken(console, command):
    """Wait until the dive has got a command."""
    end = time.monotonic() + 30.0
    while command not in console.dive.taken:
        assert time.monotonic() < end, console.dive.taken
        time.sleep(0.02)


def check_names(page, *names):
    """All controls have names for a screen reader, and these (role, name) are there."""
    tree = page.tree()
    assert not [one for one in tree if one["role"] in CONTROLS and not one["name"].strip()]
    assert {*names} <= {(one["role"], one["name"]) for one in tree}
    return tree


def check_fits(page, width):
    """A screen of that width needs no scrolling aside, and fingers and eyes find their way."""
    page.size(width, 700)
    try:
        assert page.run("document.documentElement.scrollWidth") <= width
        assert page.run(CONTRASTS) == []
        small = page.run(
            "[...document.querySelectorAll('button, select, textarea, summary, input, .button')]"
            ".filter(one => one.offsetParent && one.getBoundingClientRect().height < 44"
            " && one.type !== 'checkbox')"
            ".map(one => one.id || one.textContent)"
        )
        assert small == []
    finally:
        page.size(1024, 768)


def check_without_theatre(console, page, path, tool):
    """The page says that no theatre is shown, and hides its tool."""
    page.open(f"http://{console.host}{path}")
    page.until("!document.getElementById('none').hidden")
    assert page.run(f"document.getElementById('{tool}').hidden")
    page.open("about:blank")


def check_strangers(guarded, page, path):
    """A visitor without a token is sent to the login."""
    page.logged.clear()
    page.open(f"http://{guarded.host}{path}")
    page.until("location.pathname === '/' && document.activeElement?.id === 'token'")
    page.logged.clear()  # refusals are logged
    page.open("about:blank")
