// Light in water: what every shader of the scene shares.
uniform vec3 u_eye;          // cm
uniform vec3 u_fog;          // radiance of the far water, seen level
uniform float u_extinction;  // 1/cm
uniform float u_time;        // s
uniform sampler2D u_caustics;
uniform sampler2D u_noise;

const vec3 SUN = vec3(0.28, 0.17, 0.945);  // toward the sun, below the surface
const vec3 SUNLIGHT = vec3(3.1, 3.0, 2.75);
const vec3 SKYLIGHT = vec3(0.50, 0.72, 0.82);
// Water takes red light first: 1/cm along the light's way down, and shares of u_extinction.
const vec3 ABSORPTION = vec3(0.00115, 0.00042, 0.00026);
const float REACH = 1300.0;  // cm; the surface is not seen beyond
const float EXPOSURE = 0.62;  // of everything that is lit
const vec3 HAZE = vec3(1.30, 0.98, 0.86);

// Radiance of endless water in a direction: bright above, dark below, a glow about the sun.
vec3 water_radiance(vec3 direction) {
    float up = direction.z;
    float level = up > 0.0 ? 1.0 + 0.9 * up + up * up : 1.0 / (1.0 - 0.9 * up + 1.3 * up * up);
    vec3 tint = mix(vec3(0.9, 0.96, 1.0), vec3(1.9, 1.25, 1.05), up > 0.0 ? up * up : 0.0);
    float glow = pow(max(dot(direction, SUN), 0.0), 6.0);
    float depth = exp(u_eye.z * 0.00045);
    return (u_fog * level * tint + vec3(0.05, 0.16, 0.18) * glow) * depth;
}

// Broad shafts of light beside the view, mean 0: the caustics of a wide, slow swell.
float shafts(vec3 direction) {
    float light = 0.0;
    for (int k = 0; k < 3; ++k) {
        vec3 at = u_eye + direction * (130.0 + 210.0 * float(k));
        vec2 entry = at.xy - SUN.xy / SUN.z * at.z;
        light += textureLod(u_caustics, entry / 1150.0 + u_time * vec2(0.006, 0.004), 2.0).r;
    }
    return 0.22 * (light / 3.0 - 1.0);
}

vec3 open_water(vec3 direction) {
    return water_radiance(direction) * (1.0 + shafts(direction));
}

// The share of a colour that `distance` cm of water let through.
vec3 clearness(float distance) {
    return exp(-u_extinction * HAZE * distance);
}

// Sunlight that reaches a depth (z ≤ 0) on its slanting way.
vec3 sunlight_at(float z) {
    return SUNLIGHT * exp(ABSORPTION * z / SUN.z);
}

// Focused light on a point, mean 1: two layers that move against each other, the darker one wins.
float caustics_at(vec3 p) {
    vec2 ground = p.xy - SUN.xy / SUN.z * p.z;
    vec2 drift = vec2(0.021, 0.013) * u_time;
    float a = texture(u_caustics, ground / 190.0 + drift).r;
    float b = texture(u_caustics, ground.yx / 230.0 - drift * 0.83 + 0.37).r;
    float sharp = exp(0.0006 * p.z);
    return mix(1.0, 1.75 * min(a, b) + 0.35, 0.75 * sharp);
}

// Light on a surface: the given sun from above, sky from above, sand from below.
vec3 light_from(vec3 sun, float z, vec3 normal, float wrap) {
    float facing = max((dot(normal, SUN) + wrap) / (1.0 + wrap), 0.0);
    vec3 ambient = mix(vec3(0.16, 0.21, 0.20), SKYLIGHT, 0.5 + 0.5 * normal.z);
    return sun * facing + ambient * exp(ABSORPTION * z);
}

vec3 light_on(vec3 p, vec3 normal, float wrap) {
    return light_from(sunlight_at(p.z) * caustics_at(p), p.z, normal, wrap);
}
