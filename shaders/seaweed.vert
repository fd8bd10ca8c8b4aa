// A leaf of seaweed: a ribbon along a smooth curve through the nodes of its chain.
#include "optics.glsl"

uniform mat4 u_view_projection;
uniform sampler2D u_leaves;  // row by leaf: eight nodes, then its look
uniform int u_first;         // row of the first leaf

in vec2 a_place;  // share of its length, -1 to 1 across

out vec3 v_world;
out vec3 v_normal;
out vec3 v_place;  // along, across, own number of the leaf
flat out vec3 v_colour;
out vec3 v_clear;  // haze changes so slowly that the vertices suffice
out vec3 v_veil;

const int LAST = 7;

vec3 node(int k) {
    return texelFetch(u_leaves, ivec2(clamp(k, 0, LAST), u_first + gl_InstanceID), 0).xyz;
}

void main() {
    vec4 look = texelFetch(u_leaves, ivec2(LAST + 1, u_first + gl_InstanceID), 0);
    vec4 body = texelFetch(u_leaves, ivec2(LAST + 2, u_first + gl_InstanceID), 0);
    float t = a_place.x, own = look.w;
    // Catmull and Rom's curve.
    float s = t * float(LAST);
    int k = min(int(s), LAST - 1);
    s -= float(k);
    vec3 a = node(k - 1), b = node(k), c = node(k + 1), d = node(k + 2);
    vec3 p1 = 0.5 * (c - a), p2 = a - 2.5 * b + 2.0 * c - 0.5 * d, p3 = 0.5 * (d - a) + 1.5 * (b - c);
    vec3 place = b + s * (p1 + s * (p2 + s * p3));
    vec3 along = normalize(p1 + s * (2.0 * p2 + 3.0 * s * p3));
    float facing = look.y + look.z * t;
    vec3 side = vec3(cos(facing), sin(facing), 0.0);
    side -= along * dot(side, along);
    side = normalize(side + 1e-4 * vec3(along.y, -along.x, 0.3));
    vec3 normal = cross(along, side);
    // Narrow at the root, widest below the middle, pointed; its edges are frilled.
    float width = look.x * (0.22 + 1.05 * sqrt(t)) * sqrt(max(1.0 - t, 0.0)) * (1.0 - 0.25 * t);
    float frill = 6.2832 * (t * body.w / (5.0 + 1.6 * look.x) + own);
    float edge = a_place.y * smoothstep(0.05, 0.3, t);
    float wave = a_place.y > 0.0 ? sin(frill) : sin(1.13 * frill + 2.0);
    place += width * (0.5 * a_place.y * side + abs(edge) * (0.20 * wave + 0.12) * normal);
    // The surface leans with its frill, and is folded a little along the midrib.
    normal = normalize(normal - side * edge * (0.8 * wave + 0.45));
    v_world = place;
    v_normal = normal;
    v_place = vec3(t, a_place.y, own);
    v_colour = body.rgb;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = water_radiance(ray / distance) * (1.0 - v_clear);
    gl_Position = u_view_projection * vec4(place, 1.0);
}
