#include "optics.glsl"

in vec3 a_middle;  // cm, of the wire, about the bend
in vec3 a_normal;
in float a_radius;  // cm
in float a_kind;    // 0 metal, 1 bait, 2 line

uniform vec2 u_size;  // pixels of the viewport
uniform vec3 u_hook;  // cm
uniform float u_top;  // cm, where the line ends above the surface
uniform bool u_bait;

out vec3 v_world;
out vec3 v_normal;
flat out float v_kind;
centroid out float v_strength;

const float LINE_FOOT = 6.0;  // cm, above the bend: below that nothing is drawn out

void main() {
    vec3 middle = u_hook + a_middle;
    if (a_kind > 1.5 && a_middle.z > LINE_FOOT + 0.5) {
        middle.z = max(u_top, middle.z);
    }
    // No thinner than a pixel: what is thinner loses strength instead.
    float w = max((u_view_projection * vec4(middle, 1.0)).w, 1.0);
    float pixel = w / (u_projection[1][1] * u_size.y * 0.5);
    float radius = a_radius;
    v_strength = 1.0;
    if (a_kind > 1.5) {
        radius = max(a_radius, 0.55 * pixel);
        v_strength = clamp(a_radius / radius, 0.3, 1.0);
    } else if (a_kind > 0.5 && !u_bait) {
        radius = 0.0;
    }
    v_world = middle + radius * a_normal;
    v_normal = a_normal;
    v_kind = a_kind;
    gl_Position = u_view_projection * vec4(v_world, 1.0);
}
