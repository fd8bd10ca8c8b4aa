#include "optics.glsl"

in vec3 a_position;
in vec3 a_normal;
in vec4 a_light;  // share of the sky, of the sun, depth of the hollow, cm over the sand
#ifdef MOVING_SUN
in vec4 a_early;  // share of the sun at eight places of its course
in vec4 a_late;
uniform vec4 u_early;  // how near it is to each of them
uniform vec4 u_late;
#endif
in vec3 a_cover;  // turf, coralline algae, sponge

out vec3 v_world;
out vec3 v_normal;
centroid out vec3 v_light;  // of the sky, of the sun, hollow
centroid out vec3 v_cover;
centroid out vec3 v_clear;  // daylight and haze change so slowly that the vertices suffice
centroid out vec3 v_veil;
#ifdef OBJECT_IDS
in float a_object_id;
flat out float v_object_id;
#endif

// As `caustics_at`, blurred: a vertex stands for all that lies about it.
float dapple_at(vec3 p) {
    vec2 ground = p.xy - SUN.xy / SUN.z * p.z;
    ground += 16.0 * wave(ground.yx * vec2(0.00148, 0.00113) + u_time * vec2(0.065, 0.052));
    vec2 a = textureLod(u_caustics, mat2(0.0029, 0.0009, -0.0009, 0.0029) * ground + u_time * vec2(0.034, 0.019), 3.0).rg;
    vec2 b = textureLod(u_caustics, mat2(-0.0010, 0.0035, -0.0035, -0.0010) * ground - u_time * vec2(0.027, 0.037), 3.0).rg;
    float strong = 1.0 / (1.0 - p.z / 1600.0);  // near the surface
    return 1.0 + strong * (1.65 * min(a.x, b.x) - 0.9);
}

void main() {
    v_world = a_position;
    v_normal = a_normal;
    // Near the sand much of the sky is hidden by what lies about. Between vertices caustics are soft.
    // Water scatters so much light forward that no shadow is black.
    float open = mix(0.6, 1.0, smoothstep(-4.0, 25.0, a_light.w)) * (1.0 - 0.35 * a_light.z);
    float share = a_light.y;
#ifdef MOVING_SUN
    share = dot(a_early, u_early) + dot(a_late, u_late);
#endif
    float sun = share * dapple_at(a_position) + 0.16 * (1.0 - share);
    v_light = vec3(open * (0.65 + 1.1 * a_light.x), open * sun, a_light.z);
    v_cover = a_cover;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = open_water(ray / distance) * (1.0 - v_clear) + glow(ray / distance, distance);
    v_clear *= EXPOSURE * daylight(v_world.z);
#ifdef OBJECT_IDS
    v_object_id = a_object_id;
#endif
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
