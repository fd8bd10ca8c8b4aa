// Light in water: what every shader of the scene shares. `uniforms.py` computes it for the water
// and the hour of a scenario and the depth of the eye.
#include "view.glsl"

uniform float u_extinction;  // 1/cm, of green light along a view ray
uniform vec3 u_along;        // 1/cm, of each colour
uniform vec3 u_down;         // 1/cm, of daylight with depth
uniform vec3 u_sun;          // toward the sun, below the surface
uniform vec3 u_across;       // axes across its rays
uniform vec3 u_aside;
uniform vec3 u_sunlight;     // of a surface that faces it, at no depth
uniform vec3 u_skylight;
uniform vec3 u_sandlight;    // what the sand sends back up
uniform vec3 u_rise;         // the same over it, seen from below ...
uniform vec3 u_sink;         // ... and from above
uniform sampler2D u_caustics;  // of short waves near below them, of long ones far below
uniform sampler2D u_noise;
uniform sampler2D u_shafts;  // about the sun: turn by cosine; see shafts.frag

#define SUN u_sun
#define SUNLIGHT u_sunlight
#define SKYLIGHT u_skylight
#define SANDLIGHT u_sandlight
const float EXPOSURE = 0.62;  // of everything that is lit

// Daylight at a depth (z ≤ 0), as shares of that at the surface, to an eye at its own depth.
vec3 daylight(float z) {
    return u_balance * exp(u_down * z);
}

// Radiance of endless water in a direction: bright above, dark and blue below, and light that is
// scattered forward about the sun.
vec3 water_radiance(vec3 direction) {
    float up = max(direction.z, 0.0), down = max(-direction.z, 0.0);
    float level = (1.0 + up * (1.3 + 0.5 * up)) / (1.0 + down * (1.5 + 3.0 * down));
    level *= 1.0 + 0.9 * dot(direction.xy, SUN.xy);
    vec3 tint = mix(vec3(1.0), u_rise, up * up) * mix(vec3(1.0), u_sink, down);
    float glow = max(dot(direction, SUN), 0.0);
    glow *= glow;
    float narrow = glow * glow;
    narrow *= narrow;
    narrow *= narrow;
    return u_far * level * tint + u_broad * glow * glow + u_narrow * narrow;
}

// Shafts of light beside the view, mean about 0, from the map of this view.
float shafts(vec3 direction) {
    float turn = atan(dot(direction, u_aside), dot(direction, u_across)) / 6.2831853;
    return textureLod(u_shafts, vec2(turn, 0.5 - 0.5 * dot(direction, SUN)), 0.0).r;
}

vec3 open_water(vec3 direction) {
    return water_radiance(direction) * (1.0 + shafts(direction));
}

// The share of a colour that `distance` cm of water let through.
vec3 clearness(float distance) {
    return exp(-u_along * distance);
}

// Sunlight that reaches a depth (z ≤ 0).
vec3 sunlight_at(float z) {
    return SUNLIGHT * daylight(z);
}

// Nearly a sine of whole turns, for less.
vec2 wave(vec2 turns) {
    vec2 t = fract(turns) - 0.5;
    return t * (16.0 * abs(t) - 8.0);
}

// Focused light on a point, mean about 1: short waves focus near below the surface, long ones
// deeper. Two copies move against each other; where both are bright light is. A broad swell bends
// them and gathers light in places, so that no tile shows.
float caustics_at(vec3 p) {
    vec2 ground = p.xy - SUN.xy / SUN.z * p.z;
    vec2 swell = wave(ground.yx * vec2(0.00148, 0.00113) + u_time * vec2(0.065, 0.052));
    ground += 16.0 * swell;
    vec2 a = texture(u_caustics, mat2(0.0029, 0.0009, -0.0009, 0.0029) * ground + u_time * vec2(0.034, 0.019)).rg;
    vec2 b = texture(u_caustics, mat2(-0.0010, 0.0035, -0.0035, -0.0010) * ground - u_time * vec2(0.027, 0.037)).rg;
    vec2 both = min(a, b);
    float depth = -p.z;
    float light = 1.85 * mix(both.x, both.y, clamp(depth / 1600.0, 0.0, 1.0));
    float plain = (0.86 + 0.34 * swell.x * swell.y) * min(depth / 60.0, 1.0) / (1.0 + depth / 800.0);
    return 1.0 + plain * (light - 1.0);
}

#include "lamps.glsl"
#include "shadows.glsl"

// Light on a surface: the given sun from above, sky from above, sand from below, lamps.
vec3 light_from(vec3 sun, vec3 p, vec3 normal, float wrap) {
    float facing = max((dot(normal, SUN) + wrap) / (1.0 + wrap), 0.0);
    vec3 ambient = mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z);
    return sun * facing + ambient * daylight(p.z) + lamplight_on(p, normal, wrap);
}

vec3 light_on(vec3 p, vec3 normal, float wrap) {
    return light_from(sunlight_at(p.z) * (caustics_at(p) * sunny(p)), p, normal, wrap);
}

// Share of the sun's light that a surface of a fish gets. In water much of this light is scattered
// and comes from above, not from the sun: so a flank is lit less than the sand, and less unevenly.
const float BEAM = 0.22, SCATTERED_DOWN = 0.21;

float sunward(vec3 normal) {
    float above = 0.5 + 0.5 * normal.z;
    return BEAM * max(dot(normal, SUN), 0.0) + SCATTERED_DOWN * above * above;
}
