// A line as a strip of pixels, however it lies; an instance each.
#include "view.glsl"

uniform vec2 u_size;     // pixels of the viewport
uniform float u_width;   // pixels

in vec3 a_from;     // cm
in vec3 a_to;
in vec4 a_colour;   // as it is to appear, sRGB; opacity
in float a_lift;    // cm, by which it is taken to be nearer the eye where it could be hidden

flat out vec4 v_colour;
out float v_across;  // pixels from its middle

const float NEAREST = 0.5;  // cm: what is nearer to the eye is cut off

// How far from the eye it counts as: NDC.
float depth_of(vec3 place) {
    vec3 ray = u_eye - place;
    float lift = min(a_lift / max(length(ray), 1e-3), 0.9);
    vec4 lifted = u_view_projection * vec4(place + lift * ray, 1.0);
    return clamp(lifted.z / max(lifted.w, 1e-3), -1.0, 1.0);
}

float from_srgb(float c) {
    return c < 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// The light that `resolve.frag` shows as y: the filmic curve, backwards.
float uncurved(float y) {
    y = clamp(y, 0.0, 0.995);
    float a = 2.43 * y - 2.51, b = 0.59 * y - 0.03, c = 0.14 * y;
    return (-b - sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

float curved(float x) {
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// The same for colours, whose channels that curve mixes: by halves.
vec3 light_of(vec3 y) {
    float most = max(max(y.r, max(y.g, y.b)), 1e-4);
    float bright = uncurved(most), kept = 0.4 - 0.4 * most * most, share = kept * most / bright;
    vec3 light;
    for (int k = 0; k < 3; ++k) {
        float low = 0.0, high = bright;
        for (int step = 0; step < 12; ++step) {
            float x = 0.5 * (low + high);
            if ((1.0 - kept) * curved(x) + share * x < y[k]) low = x;
            else high = x;
        }
        light[k] = 0.5 * (low + high);
    }
    return light;
}

void main() {
    vec3 from = a_from, to = a_to;
    float a = (u_view_projection * vec4(from, 1.0)).w, b = (u_view_projection * vec4(to, 1.0)).w;
    if (max(a, b) <= NEAREST) {
        gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
        return;
    }
    if (a < NEAREST) from = mix(from, to, (NEAREST - a) / (b - a));
    if (b < NEAREST) to = mix(to, from, (NEAREST - b) / (a - b));
    vec4 begin = u_view_projection * vec4(from, 1.0), end = u_view_projection * vec4(to, 1.0);
    vec2 p = 0.5 * u_size * begin.xy / begin.w, q = 0.5 * u_size * end.xy / end.w;
    vec2 along = q - p;
    float distance = length(along);
    along = distance > 1e-3 ? along / distance : vec2(1.0, 0.0);
    float reach = 0.5 * u_width + 0.5;
    bool second = gl_VertexID >= 2;
    v_across = gl_VertexID % 2 == 0 ? -reach : reach;
    vec2 place = (second ? q : p) + v_across * vec2(-along.y, along.x);
    place += (second ? 0.5 : -0.5) * along;
    gl_Position = vec4(2.0 * place / u_size, depth_of(second ? to : from), 1.0);
    // What is blended is light, before the curve: so a faint line is given the light of its share.
    vec3 y = vec3(from_srgb(a_colour.r), from_srgb(a_colour.g), from_srgb(a_colour.b));
    float opacity = max(a_colour.a, 1e-3);
    v_colour = vec4(u_unit * light_of(opacity * y) / opacity, opacity);
}
