#include "optics.glsl"

in vec3 v_ray;
out vec4 f_colour;

const float WATER_INDEX = 1.33;
const vec3 SUN_IN_AIR = normalize(vec3(1.33 * SUN.xy, 0.9));

// Broad shafts of light: the caustics of a slow, wide swell, seen from the side.
float shafts(vec3 direction) {
    float light = 0.0;
    for (int k = 0; k < 3; ++k) {
        vec3 at = u_eye + direction * (130.0 + 210.0 * float(k));
        vec2 entry = at.xy - SUN.xy / SUN.z * at.z;
        light += textureLod(u_caustics, entry / 1150.0 + u_time * vec2(0.006, 0.004), 2.0).r;
    }
    return light / 3.0 - 1.0;
}

// Slope of the noise, read as the height of waves.
vec2 slope_of(vec2 at) {
    const float STEP = 1.0 / 128.0;
    float here = texture(u_noise, at).r;
    return vec2(texture(u_noise, at + vec2(STEP, 0.0)).r, texture(u_noise, at + vec2(0.0, STEP)).r) - here;
}

// The surface from below: the sky within Snell's window, the deep mirrored around it.
vec3 surface(vec3 direction, vec2 at, float distance) {
    vec2 slope = slope_of(at / 900.0 + u_time * vec2(0.008, 0.005));
    slope += 0.6 * slope_of(at.yx / 340.0 - u_time * vec2(0.011, 0.017));
    slope *= 0.9 * exp(-distance / 1500.0);
    vec3 normal = normalize(vec3(slope, -1.0));
    vec3 beyond = refract(direction, normal, WATER_INDEX);
    vec3 mirrored = water_radiance(reflect(direction, normal));
    if (beyond == vec3(0.0)) return mirrored;
    float facing = -dot(direction, normal);
    float mirror = pow(1.0 - clamp((facing - 0.66) / 0.34, 0.0, 1.0), 4.0);
    vec3 sky = mix(vec3(0.45, 0.85, 1.05), vec3(0.75, 1.2, 1.35), beyond.z);
    sky += vec3(4.0, 3.8, 3.2) * pow(max(dot(beyond, SUN_IN_AIR), 0.0), 90.0);
    return mix(sky, mirrored, mirror);
}

void main() {
    vec3 direction = normalize(v_ray);
    vec3 colour = water_radiance(direction) * (1.0 + 0.22 * shafts(direction));
    if (direction.z > 0.02 && u_eye.z < 0.0) {
        float distance = -u_eye.z / direction.z;
        vec2 at = u_eye.xy + direction.xy * distance;
        vec3 kept = exp(-u_extinction * HAZE * distance);
        colour = mix(colour, surface(direction, at, distance), kept);
    }
    f_colour = vec4(colour, 1.0);
}
