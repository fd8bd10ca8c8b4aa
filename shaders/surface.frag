// The surface from below: the sky within Snell's window, the deep and the lit sand mirrored about
// it. Ripples that are too small to be seen widen the edge of the window and the sun's glitter.
#include "optics.glsl"
#include "show.glsl"

uniform sampler2D u_waves;  // slopes along x and y, the variance that mipmaps average out
uniform float u_floor;

in vec3 v_world;
in float v_share;
flat in vec3 v_level;
flat in vec3 v_deep;
flat in vec3 v_sand;
flat in vec3 v_sun;
flat in vec3 v_sun_in_air;
flat in vec3 v_sky;   // the sky's light and the sun's, over those of noon
flat in vec3 v_disc;

const float WATER_INDEX = 1.33;
const float CRITICAL = 0.6593;  // cosine of the steepest angle at which all light is mirrored
const vec3 FOAM = vec3(0.62, 0.60, 0.58);
const vec3 ZENITH = vec3(0.16, 0.48, 0.90), HORIZON = vec3(0.80, 1.15, 1.30);

const float MOST_SLOPE = 4.0;  // of the texture's bytes

// Adds waves of some deviation of slope; the third component gathers the variance not resolved.
void add(inout vec3 waves, vec2 at, float deviation, mat2 turn) {
    vec3 texel = texture(u_waves, turn * at).rgb;
    waves.xy += deviation * MOST_SLOPE * (2.0 * texel.xy - 1.0) * turn;
    waves.z += deviation * deviation * MOST_SLOPE * texel.z;
}

void main() {
    vec3 direction = normalize(v_world - u_eye);
    vec3 waves = vec3(0.0);
    add(waves, v_world.xy / 1300.0 + u_time * vec2(0.022, 0.013), 0.055, mat2(1.0));
    add(waves, v_world.xy / 410.0 + u_time * vec2(0.045, 0.060), 0.075, mat2(0.8, -0.6, 0.6, 0.8));
    add(waves, v_world.xy / 101.0 - u_time * vec2(0.110, 0.140), 0.085, mat2(0.6, 0.8, -0.8, 0.6));
#ifdef CLOSE_UP
    // A swell tilts all smaller waves, and foam lies where they break.
    add(waves, v_world.xy / 4300.0 + u_time * vec2(0.014, 0.009), 0.070, mat2(0.95, 0.31, -0.31, 0.95));
    float patches = texture(u_noise, v_world.xy / 1900.0 + u_time * vec2(0.011, 0.006)).r;
    float threads = texture(u_noise, v_world.xy / 260.0 + 0.02 * waves.xy + u_time * vec2(0.020, 0.011)).r;
    float foam = smoothstep(0.9, 2.0, patches + 0.8 * dot(waves.xy, vec2(5.0, 3.4)) - 0.9)
        * smoothstep(-0.2, 0.9, 0.55 - abs(threads));
#endif
    vec3 normal = normalize(vec3(waves.xy, -1.0));
    float facing = max(-dot(direction, normal), 0.0);
    float spread = sqrt(0.5 * waves.z);

    vec3 below = reflect(direction, normal);
    float down = max(-below.z, 0.02);
    vec3 mirrored = mix(v_level, v_deep, sqrt(down));
    mirrored = mix(mirrored, v_sand, exp(u_extinction * u_floor / down));

    float level = 1.0 - WATER_INDEX * WATER_INDEX * (1.0 - facing * facing);
    vec3 beyond = WATER_INDEX * direction + (WATER_INDEX * facing - sqrt(max(level, 0.0))) * normal;
    float high = clamp(beyond.z, 0.0, 1.0);
    // Each crest is a lens: one slope of a ripple gathers more of the sky than the other.
    vec3 sky = v_sky * mix(HORIZON, ZENITH, high) * (1.0 + 2.2 * dot(waves.xy, vec2(0.83, 0.56)));
    float width = 0.0006 + 0.25 * waves.z;
    float off = max(1.0 - dot(beyond, v_sun_in_air), 0.0);
    sky += v_disc * (120.0 * 0.0006 / width * exp(-off / width) + 2.2 * exp(-off * 45.0));

    float within = smoothstep(CRITICAL - 0.01 - 1.5 * spread, CRITICAL + 0.07 + 1.5 * spread, facing);
    vec3 colour = mix(mirrored, sky * v_sun, within);
#ifdef CLOSE_UP
    // Bubbles scatter the light of the whole sky; in the window they are darker than it, else brighter.
    colour = mix(colour, FOAM * SKYLIGHT * v_sun, 0.75 * foam);
#endif
    // What the water before it adds is there already, with its shafts.
#ifdef PASSES
    show_parts(colour, vec3(0.0), vec3(1.0), 1.0 / clearness(distance(v_world, u_eye)).g, v_share);
#else
    show(colour, vec3(0.0), vec3(1.0), v_share);
#endif
}
