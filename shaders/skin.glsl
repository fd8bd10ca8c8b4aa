// What lies on a fish: scales, each with a tilt of its own, and eyes that bulge.

const vec2 SCALES = vec2(72.0, 32.0);  // per body length along, from ridge to ridge
const float TILT = 0.24, ROUND = 0.34;  // of a scale: at random, and as it bulges

// Two numbers of a scale's own, -0.5 to 0.5.
vec2 chance(vec2 cell, float identity) {
    ivec2 c = ivec2(cell);
    uint h = uint(c.x) * 1597334677u ^ uint(c.y + int(911.0 * identity)) * 3812015801u;
    h = (h ^ (h >> 15u)) * 2246822519u;
    return vec2(float((h >> 8u) & 1023u), float((h >> 18u) & 1023u)) / 1023.0 - 0.5;
}

// Slope of the surface (tailward, up) where scales overlap, and how bright it is there. They blur
// away before they alias: `seen` is how much is left of them.
vec3 scales(vec2 place, float across, float identity, float plain, out float seen) {
    vec2 cell = vec2(place.x, across) * SCALES;
    vec2 grain = fwidth(cell);
    seen = plain * (1.0 - smoothstep(0.3, 0.9, max(grain.x, grain.y)));
    float off = fract(cell.y) - 0.5;
    cell.x += 0.5 * mod(floor(cell.y), 2.0) + 2.0 * off * off;  // round behind
    vec2 own = chance(floor(cell), identity);
    vec2 within = fract(cell) - 0.5;
    vec2 slope = seen * (TILT * own + ROUND * vec2(within.x, -0.6 * within.y));
    // Darker where it goes under the one before it.
    float edge = smoothstep(-0.5, -0.2, within.x) - 0.7 * dot(within, within);
    return vec3(slope, 1.0 + seen * (0.36 * edge - 0.25 + 0.10 * own.x));
}
