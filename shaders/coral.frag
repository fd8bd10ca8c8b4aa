#include "optics.glsl"
#include "bites.glsl"
#define BRIGHTEST 16.0
#include "show.glsl"
#ifdef FADING
#include "fades.glsl"
#endif

uniform sampler2D u_grain;  // ridges, polyps, pores
#ifdef CLOSE_UP
uniform sampler2D u_polyps;  // of cups: slopes, height; pits
#endif

in vec3 v_world;
in vec3 v_normal;
in float v_sunward;
centroid in vec4 v_colour;
centroid in vec4 v_grain;
in vec2 v_along;
centroid in float v_caustics;
centroid in vec3 v_clear;
centroid in vec3 v_veil;

#ifdef CLOSE_UP
const vec4 POLYP_SPAN = vec4(8.0, 8.0, 4.0, 4.0);  // of the texture's bytes, about 0
const float FINER = 7.0;  // than the grain
const float STEEP = 0.24;  // slope of the walls of cups, of a deviation in the texture

// A normal that leans away from where a height over `along` rises by `slope`.
vec3 leaning(vec3 normal, vec2 slope) {
    vec3 dx = cross(dFdy(v_world), normal), dy = cross(normal, dFdx(v_world));
    vec3 u = dx * dFdx(v_along).x + dy * dFdy(v_along).x;
    vec3 v = dx * dFdx(v_along).y + dy * dFdy(v_along).y;
    return normalize(normal - (slope.x * u + slope.y * v) * inversesqrt(max(max(dot(u, u), dot(v, v)), 1e-12)));
}
#endif

const vec3 SKELETON = vec3(0.86, 0.82, 0.74);  // of a coral, where its polyps are gone

void main() {
#ifdef FADING
    if (faded(u_fade)) discard;
#endif
    float height = dot(v_grain.xyz, texture(u_grain, v_along).rgb);
    vec3 normal = normalize(v_normal);
    // Which way on the grain the sun is: what rises toward it is darker.
    vec2 sunward = dFdx(v_sunward) * dFdx(v_along) + dFdy(v_sunward) * dFdy(v_along);
    sunward *= 0.007 * inversesqrt(dot(sunward, sunward) + 1e-12);
    float rise = dot(v_grain.xyz, texture(u_grain, v_along + sunward).rgb) - height;
    vec3 sun = SUNLIGHT * (v_caustics * sunny(v_world + 1.5 * normal));
    // Valleys between ridges are a shade of their own.
    vec3 colour = mix(v_colour.rgb, SKELETON, bitten(v_world)) * clamp(1.0 + vec3(0.58, 0.46, 0.62) * height, 0.25, 1.6);
    float open = v_grain.a * clamp(1.0 + 0.5 * height, 0.4, 1.2);
#ifdef CLOSE_UP
    // Farther off than an arm's length the texture is even: its mean is 0.
    vec4 fine = POLYP_SPAN * texture(u_polyps, v_along * FINER) - 0.5 * POLYP_SPAN;
    float cups = min(v_grain.y + 0.5 * v_grain.x, 1.0), pits = v_grain.z;
    normal = leaning(normal, STEEP * cups * fine.xy);
    float relief = cups * fine.z + pits * fine.w;
    colour *= clamp(1.0 + vec3(0.28, 0.25, 0.22) * relief, 0.3, 1.5);
    open *= clamp(1.0 + 0.3 * relief, 0.5, 1.15);
#endif
    float facing = max(dot(normal, SUN) + 0.25, 0.0) / 1.25 * clamp(1.0 - 1.6 * rise, 0.2, 2.0);
    vec3 light = sun * (facing + v_colour.a) + mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z);
#ifdef LIT
    light += lamplight_on(v_world, normal, 0.25) / daylight(v_world.z);  // as that is in `v_clear`
#endif
    vec3 lit = colour * light * open;
#ifdef CLOSE_UP
    vec3 view = normalize(v_world - u_eye);
    // Living skin is wet, and a fuzz of tentacles catches light at its outline.
    float rim = 1.0 - clamp(-dot(normal, view), 0.0, 1.0);
    float mirror = max(dot(normal, normalize(SUN - view)), 0.0);
    mirror *= mirror; mirror *= mirror; mirror *= mirror; mirror *= mirror;
    lit += open * (0.05 * mirror * mirror + 0.25 * rim * rim * rim * v_colour.rgb) * sun;
#endif
    show(lit * v_clear, v_veil, v_clear / (EXPOSURE * daylight(v_world.z)), 1.0);
}
