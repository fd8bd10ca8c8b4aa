#include "optics.glsl"

in vec2 a_place;  // on the unit disc about the eye

uniform float u_floor;  // cm, mean height of the seabed

out vec3 v_world;
out float v_share;
flat out vec3 v_level;  // of the water that the surface mirrors
flat out vec3 v_deep;
flat out vec3 v_sand;
flat out vec3 v_sun_in_air;
flat out vec3 v_sky;
flat out vec3 v_disc;
flat out vec3 v_sun;  // what has come down to the eye of it, but for what is scattered aside

const vec3 NOON_SKY = vec3(0.50, 0.76, 0.95), NOON_SUN = vec3(5.3, 4.2, 3.6);  // as in `uniforms.py`
const vec3 SAND = vec3(0.58, 0.47, 0.31);

// The water's surface as far as it can be seen: hardly any contrast is left at its edge.
void main() {
    float reach = max(3.4 / u_extinction, -3.0 * u_eye.z);
    v_world = vec3(u_eye.xy + reach * a_place, 0.0);
    float distance = length(v_world - u_eye);
    v_share = clearness(distance).g * (1.0 - smoothstep(0.55, 0.95, length(a_place)));
#ifdef OBJECT_IDS
    v_share = 1.0;  // haze hides nothing from who asks what is where
#endif
    v_level = water_radiance(vec3(1.0, 0.0, 0.0));
    v_deep = water_radiance(vec3(0.0, 0.0, -1.0));
    v_sand = EXPOSURE * SAND * SUN.z * sunlight_at(u_floor) * exp((u_along - u_extinction) * (u_floor + u_eye.z));
    v_sky = SKYLIGHT / NOON_SKY;
    v_disc = vec3(1.0, 0.94, 0.82) * SUNLIGHT / NOON_SUN;
    vec2 flat_sun = 1.33 * SUN.xy;
    v_sun_in_air = vec3(flat_sun, sqrt(max(1.0 - dot(flat_sun, flat_sun), 1e-4)));
    v_sun = daylight(u_eye.z);
    gl_Position = u_view_projection * vec4(v_world, 1.0);
}
