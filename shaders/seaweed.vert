// Seaweed: fronds along the smooth curve through the nodes of a chain, or that grow from it.
#include "optics.glsl"

uniform vec2 u_size;  // pixels of the viewport
uniform sampler2D u_leaves;  // row by leaf: eight nodes, of which the first tells the kind and the
                             // second what it lacks; its look

in vec2 a_place;  // share of its length, -1 to 1 across
in vec3 a_frond;  // row of its leaf, its number among the fronds of that, 1: drawn only near

out vec3 v_world;
out vec3 v_normal;
out vec4 v_place;  // along, across, own number of the frond, how high on its plant
flat out vec3 v_colour;
flat out float v_rib;  // how much of a midrib it has
centroid out vec3 v_sun;
centroid out vec3 v_clear;  // haze changes so slowly that the vertices suffice
centroid out vec3 v_veil;

const int LAST = 7;
const int RIBBON = 0, KELP = 1, GRASS = 2, RED = 3;
const float FLOAT = 0.14;    // share of a blade of kelp that is its float ...
const float FLOAT_ROWS = 0.2;  // ... and of the rows of its vertices
const float WAVES = 3.0, KELP_WAVES = 2.0;  // of a frill at most: more would zigzag between vertices
const float STIPES = 3.0, BLADES = 48.0, CANOPY = 8.0, BRANCHES = 15.0;
const vec2 BLADE_LENGTH = vec2(5.0, 3.5), CANOPY_LENGTH = vec2(9.0, 7.0);  // least and more, over its width
const vec2 CANOPY_CM = vec2(-150.0, -70.0);  // height of the tip from which a canopy grows, and is full
const float TALL_CM = 450.0;  // length of kelp beyond which its blades are larger
const float SEGMENTS = 6.0;  // of a coarse ribbon
const vec3 UP = vec3(0.0, 0.0, 1.0);

vec4 texel(int k) {
    return texelFetch(u_leaves, ivec2(k, int(a_frond.x)), 0);
}

vec3 node(int k) {
    return texel(clamp(k, 0, LAST)).xyz;
}

// Catmull and Rom's curve.
vec3 curve(float t, out vec3 along) {
    float s = t * float(LAST);
    int k = clamp(int(s), 0, LAST - 1);
    s -= float(k);
    vec3 a = node(k - 1), b = node(k), c = node(k + 1), d = node(k + 2);
    vec3 p1 = 0.5 * (c - a), p2 = a - 2.5 * b + 2.0 * c - 0.5 * d, p3 = 0.5 * (d - a) + 1.5 * (b - c);
    along = normalize(p1 + s * (2.0 * p2 + 3.0 * s * p3));
    return b + s * (p1 + s * (p2 + s * p3));
}

// The stipes of one holdfast wind about its chain.
vec3 beside(float stipe, float t, float own, float width) {
    float turn = 2.0944 * stipe + 6.2832 * own + 4.0 * t;
    float away = width * (0.25 + 2.2 * t * (1.4 - t));
    return away * vec3(cos(turn), sin(turn), 0.0);
}

void main() {
    vec4 first = texel(0);
    int kind = int(first.w + 0.5);
    vec4 look = texel(LAST + 1), body = texel(LAST + 2);
    // Far off a ribbon becomes its coarse one, point by point, and fronds that those lack are short.
    float lacks = texel(1).w, coarse = min(lacks, 1.0);
    float size = (1.0 - max(lacks - 1.0, 0.0)) * (1.0 - coarse * a_frond.z);
    vec2 at_coarse = vec2(floor(a_place.x * SEGMENTS + 0.5) / SEGMENTS, a_place.y > 0.0 ? 1.0 : -1.0);
    vec2 within = mix(a_place, at_coarse, coarse);
    float t = within.x, k = a_frond.y;
    bool stem = kind != KELP ? k < 0.5 : k < STIPES - 0.5;
    bool canopy = kind == KELP && k > STIPES + BLADES - 0.5;
    bool branch = !stem && (kind == KELP || kind == RED);
    float own = fract(look.w + 0.618 * k), azimuth = 6.2832 * look.w + 2.4 * k;
    vec3 out_way = vec3(cos(azimuth), sin(azimuth), 0.0);
    // Where on the chain it is, or grows from.
    float at = t, blade_number = k - STIPES;
    if (canopy) at = 1.0 - 0.12 * own;
    else if (branch) at = kind == KELP ? 0.05 + 0.95 * (blade_number + 1.0 - 0.4 * own) / BLADES : 0.08 + 0.75 * k / BRANCHES;
    if (kind == GRASS) at = t * mix(0.5, 1.0, own);
    vec3 along;
    vec3 place = curve(at, along);
    float facing = look.y + look.z * t, length_cm = body.w;
    // Narrow at the root, widest below the middle, pointed; its edges are frilled.
    float width = look.x * (0.22 + 1.05 * sqrt(t)) * sqrt(max(1.0 - t, 0.0)) * (1.0 - 0.25 * t);
    float frilled = 1.0, rib = 1.0, high = t, grown = 1.0;
    vec3 colour = body.rgb;
    vec3 eyeward = normalize(u_eye - place);
    vec3 side = vec3(cos(facing), sin(facing), 0.0);

    if (kind == GRASS) {
        place += out_way * look.x * (1.0 + 7.0 * own) * (0.5 + 0.6 * t * t);
        along = normalize(along + 0.25 * t * out_way);
        width = 0.35 * look.x * (1.0 - t * t);
        side = vec3(-out_way.y, out_way.x, 0.0);
        frilled = 0.0;
        colour *= 0.75 + 0.5 * own;
    } else if (kind == KELP && stem) {
        place += beside(k, t, look.w, look.x);
        // A claw of roots at its foot.
        width = look.x * (0.19 * (1.0 - 0.55 * t) + 0.5 * max(1.0 - 14.0 * t, 0.0));
        side = cross(along, eyeward);  // round: it turns with the eye
        frilled = rib = 0.0;
        colour *= mix(vec3(0.55, 0.5, 0.5), vec3(1.0), smoothstep(0.0, 0.3, t));
    } else if (branch) {
        // Away from the stem, then down and along with the water.
        bool kelp = kind == KELP;
        vec2 reach = canopy ? CANOPY_LENGTH : BLADE_LENGTH;
        length_cm = kelp ? look.x * (reach.x + reach.y * own) : body.w * (0.62 - 0.55 * at) * (0.7 + 0.5 * own);
        float s = t;
        if (kelp) {
            // The rows of its blade lie evenly on the outline, which is nearly half an ellipse.
            float row = (t - FLOAT_ROWS) / (1.0 - FLOAT_ROWS);
            s = row < 0.0 ? FLOAT * t / FLOAT_ROWS : FLOAT + (1.0 - FLOAT) * (0.5 - 0.5 * cos(3.1416 * row));
            place += beside(mod(blade_number, STIPES), at, look.w, look.x);
            // The youngest, at the tip, are small; old ones are dark.
            if (canopy) size *= smoothstep(CANOPY_CM.x, CANOPY_CM.y, place.z);
            else grown = clamp(body.w / TALL_CM, 1.0, 1.7);
            length_cm *= canopy ? 1.0 : grown - 0.45 * smoothstep(0.8, 1.0, at);
            colour *= mix(vec3(0.62, 0.60, 0.66), vec3(1.15, 1.1, 1.0), at) * (0.75 + 0.5 * fract(7.0 * own));
        }
        length_cm *= size;
        if (!kelp) out_way = (mod(k, 2.0) < 0.5 ? 1.0 : -1.0) * side + 0.35 * out_way;
        vec3 rise = along;
        vec3 way = normalize(0.9 * out_way + (kelp ? 0.7 + 0.5 * own : 0.8) * rise);
        vec3 bend = kelp ? vec3(0.6 * rise.xy, -0.35 - 0.3 * own) : 0.4 * rise;
        float flap = 2.1 * u_time - 5.0 * s + 6.2832 * own;
        vec3 wave = vec3(sin(flap), cos(0.8 * flap), 0.5 * sin(1.3 * flap)) * (kelp ? 0.06 : 0.03);
        if (canopy) {
            // Up to the surface, and along it with the water.
            vec2 drift = node(LAST).xy - first.xy;
            drift = normalize(drift + 0.5 * body.w * 0.2 * out_way.xy);
            float up = -3.0 - 7.0 * own - place.z;
            way = vec3(0.75 * drift, 0.0);
            bend = vec3(0.35 * out_way.xy, 0.0);
            place.z += up * size * (1.0 - exp(-5.0 * s));
            rise = normalize(vec3(way.xy * length_cm, 5.0 * up * exp(-5.0 * s)) + vec3(0.0, 0.0, 1e-3));
            place += length_cm * (s * way + s * s * (bend + wave));
            along = normalize(rise + vec3(0.0, 0.0, 0.2) * wave.z);
        } else {
            place += length_cm * (s * way + s * s * (bend + wave));
            along = normalize(way + 2.0 * s * (bend + wave));
        }
        high = at;
        if (kelp) {
            float blade = clamp((s - FLOAT) / (1.0 - FLOAT), 0.0, 1.0);
            float ball = sin(3.1416 * min(s / FLOAT, 1.0));
            width = grown * look.x * (1.75 * sqrt(blade * (1.0 - blade)) * (1.0 - 0.45 * blade));
            if (t < FLOAT_ROWS) {
                width = 0.07 * look.x + 0.3 * look.x * ball;
                side = cross(along, eyeward);
                colour = mix(colour, vec3(0.20, 0.16, 0.05), 0.6);
                frilled = rib = 0.0;
            } else {
                side = canopy ? vec3(-along.y, along.x, 0.4 * sin(9.0 * own))
                    : cross(along, normalize(vec3(out_way.yx * vec2(-0.5, 0.5), 1.0)));
                frilled = 1.4;
                rib = 0.25;
            }
            t = s;
        } else {
            width = look.x * (0.35 + 0.5 * sin(3.0 * t)) * (1.0 - 0.6 * t);
            side = cross(along, vec3(-out_way.y, out_way.x, 0.3));
        }
    } else if (kind == RED) {
        width = look.x * (0.45 + 0.3 * sin(3.0 * t)) * (1.0 - 0.5 * t);
    }
    width *= size;
    // No narrower than a pixel, or it would break into dots. Kelp, which stands before open water,
    // fades instead.
    float strength = 1.0;
    if (kind == GRASS || (kind == KELP && stem)) {
        float pixel = max((u_view_projection * vec4(place, 1.0)).w, 1.0) * 2.0 / (u_projection[1][1] * u_size.y);
        if (kind == KELP) strength = clamp(width / pixel, 0.4, 1.0);
        width = max(width, pixel * size);
    }
    side -= along * dot(side, along);
    side = normalize(side + 1e-4 * vec3(along.y, -along.x, 0.3));
    vec3 normal = cross(along, side);
    float waves = min(length_cm / (5.0 + 1.6 * look.x), kind == KELP ? KELP_WAVES : WAVES);
    float frill = 6.2832 * (t * waves + own);
    // The few vertices of a coarse ribbon would make corners of its frill.
    float edge = within.y * smoothstep(0.05, 0.3, t) * frilled * (1.0 - coarse);
    float wave = within.y > 0.0 ? sin(frill) : sin(1.13 * frill + 2.0);
    // Ragged: no two waves of its edge are as wide.
    float ragged = 1.0 + 0.13 * min(frilled, 1.0) * sin(1.4 * frill + 5.0 * within.y) * t;
    place += width * (0.5 * ragged * within.y * side + abs(edge) * (0.20 * wave + 0.12) * normal);
    // Beneath the surface, which bends it over.
    if (kind == KELP && place.z > -10.0) place.z = -4.0 - 6.0 * exp(-(place.z + 10.0) / 6.0);
    // The surface leans with its frill, and is folded a little along the midrib; what is round bulges.
    normal = normalize(normal - side * edge * (0.8 * wave + 0.45) + (1.0 - min(frilled, 1.0)) * within.y * side);
    v_world = place;
    v_normal = normal;
    v_place = vec4(t, within.y, own, high);
    v_colour = colour;
    v_rib = rib;
    v_sun = sunlight_at(place.z) * (caustics_at(place) * sunny(place));
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = strength * clearness(distance);
    v_veil = water_radiance(ray / distance) * (1.0 - v_clear) + glow(ray / distance, distance);
    gl_Position = u_view_projection * vec4(place, 1.0);
}
