// Corals, sponges and anemones. What is soft sways with the water.
#include "optics.glsl"
#include "sway.glsl"

in vec3 a_position;
in vec4 a_normal;  // and sway
in vec4 a_colour;  // its root, and what shines through
in vec4 a_grain;   // ridges, polyps, pores, and light
in vec2 a_along;   // place on the grain

out vec3 v_world;
out vec3 v_normal;
out float v_sunward;  // cm toward the sun
centroid out vec4 v_colour;  // and what glows from behind
centroid out vec4 v_grain;
out vec2 v_along;
centroid out float v_caustics;  // vertices are closer together than their lines
centroid out vec3 v_clear;      // daylight and haze change so slowly that the vertices suffice
centroid out vec3 v_veil;
#ifdef OBJECT_IDS
in float a_object_id;
flat out float v_object_id;
#endif

const float MOST_SWAY_CM = 10.0;

void main() {
    vec3 place = a_position;
    place += MOST_SWAY_CM * a_normal.w * sway_at(place);
    v_world = place;
    v_normal = 2.0 * a_normal.xyz - 1.0;
    v_sunward = dot(place, SUN);
    v_grain = a_grain;
    v_along = a_along;
    v_caustics = caustics_at(place);
    vec3 ray = place - u_eye;
    float distance = length(ray);
    // Thin parts and tips glow with the light from behind.
    float behind = max(dot(ray, SUN) / distance, 0.0);
    v_colour = vec4(a_colour.rgb * a_colour.rgb, a_colour.a * (0.16 + 0.5 * behind * behind));
    v_clear = clearness(distance);
    v_veil = open_water(ray / distance) * (1.0 - v_clear) + glow(ray / distance, distance);
    v_clear *= EXPOSURE * daylight(place.z);
#ifdef OBJECT_IDS
    v_object_id = a_object_id;
#endif
    gl_Position = u_view_projection * vec4(place, 1.0);
}
