#include "optics.glsl"

in vec3 v_world;
out vec4 f_colour;

const float WATER_INDEX = 1.33;
const vec3 SUN_IN_AIR = normalize(vec3(1.33 * SUN.xy, 0.9));

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
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    vec3 colour = surface(ray / distance, v_world.xy, distance);
    float share = 1.0 - smoothstep(0.5 * REACH, REACH, distance);
    f_colour = vec4(colour, share * clearness(distance).g);
}
