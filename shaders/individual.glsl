// What makes a fish differ from others of its species: `identity` is a number in [0, 1).

// Place on a skin, in shares of its cell of the atlas, of a place on the body.
vec2 on_body(vec2 place, int kind) {
    vec4 box = looks[kind].skin_box;
    return frames[4].xy + frames[4].zw * (clamp(place, box.xy, box.zw) - box.xy) / (box.zw - box.xy);
}

// The same of a place in the frame of a fin.
vec2 on_fin(vec2 place, int frame) {
    return frames[frame].xy + frames[frame].zw * place;
}

// -1 to 1, another for each `which`.
vec3 lot(float identity, float which) {
    return 2.0 * fract(identity * vec3(61.7, 97.3, 151.9) + which) - 1.0;
}

// A tint, and how saturated it is.
vec4 tone(float identity, int kind, float display) {
    float pale = max(-display, 0.0);  // by night
    display = max(display, 0.0);
    vec4 vary = looks[kind].vary, build = looks[kind].build;
    vec3 hue = lot(identity, 0.0), own = lot(identity, 0.37);
    vec3 tint = 1.0 + vary.x * (hue - dot(hue, vec3(1.0 / 3.0)));
    float bright = (1.0 + vary.z * own.x) * mix(1.0, build.z, display) * (1.0 + 0.15 * pale);
    return vec4(tint * bright, (1.0 + vary.y * own.y) * mix(1.0, looks[kind].show.w, display) * (1.0 - 0.5 * pale));
}

// Where along its dorsal fin a fish has a nick, 0 to 1, or far outside.
float nick(float identity, int kind) {
    vec3 own = 0.5 + 0.5 * lot(identity, 0.53);
    return own.x < looks[kind].build.w ? 0.25 + 0.6 * own.y : 9.0;
}

// The scar of a fish: its middle, shares of the body along and across, its slant and its length;
// no length if it has none.
vec4 scar(float identity, int kind) {
    vec3 own = 0.5 + 0.5 * lot(identity, 0.19), more = 0.5 + 0.5 * lot(identity, 0.83);
    float tail = looks[kind].build.y, head = looks[kind].eye.x + 0.2;
    float size = own.x < looks[kind].jaws.w ? 0.04 + 0.07 * more.z : 0.0;
    return vec4(mix(head, tail, 0.15 + 0.7 * own.y), 0.25 + 0.5 * own.z, more.x - 0.5, size);
}

// Where its eyes look: each jumps now and then, -1 to 1 along and up.
vec2 gaze(float identity, float side) {
    float beat = u_time * (0.45 + 0.3 * identity) + 31.0 * identity + 0.37 * side;
    vec2 now = vec2(floor(beat), floor(beat) - 1.0) + 7.3 * side;
    vec2 along = 2.0 * fract(sin(now * 12.9898 + 61.0 * identity) * 43758.5453) - 1.0;
    vec2 up = 2.0 * fract(sin(now * 78.233 + 17.0 * identity) * 24634.6345) - 1.0;
    float moved = smoothstep(0.0, 0.08, fract(beat));
    return vec2(mix(along.y, along.x, moved), mix(up.y, up.x, moved));
}

// How far the pattern is displaced: neither on the head nor the tail, nor where fins go on with it.
vec2 displaced(vec2 place, float across, float identity, int kind) {
    vec3 own = 3.1416 * lot(identity, 0.71);
    float eye = looks[kind].eye.x, tail = looks[kind].build.y;
    float much = looks[kind].vary.w * 4.0 * across * (1.0 - across);
    much *= smoothstep(eye + 0.10, eye + 0.22, place.x) * (1.0 - smoothstep(tail - 0.1, tail, place.x));
    vec3 scale = 2.0 * lot(identity, 0.29);
    return much * vec2(
        scale.x * (place.x - 0.5) + sin(17.0 * place.y + own.x + 6.0 * place.x) + 0.5 * sin(31.0 * place.x + own.y),
        scale.y * place.y + 0.7 * sin(13.0 * place.x + own.z - 9.0 * place.y));
}
