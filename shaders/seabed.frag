// Sand: ripple marks in two directions, grain, litter, and rubble about what stands on it. Without
// CLOSE_UP they are in one, which costs one read of a texture and not two.
#include "optics.glsl"
#define BRIGHTEST 16.0
#include "show.glsl"
#ifdef FADING
#include "fades.glsl"
#endif

uniform sampler2D u_ground;   // share of the sun, of the sky, of rubble
#ifdef MOVING_SUN
uniform sampler2D u_early_suns;  // share of the sun at eight places of its course
uniform sampler2D u_late_suns;
uniform vec4 u_early;  // how near it is to each of them
uniform vec4 u_late;
#endif
uniform sampler2D u_ripples;  // slopes, height, grain
uniform sampler2D u_litter;   // slopes, tone, how common
uniform vec2 u_flow;          // along the current, across which ripples lie
#ifdef CLOSE_UP
uniform sampler2D u_tracks;   // slopes, height
#endif
uniform vec4 u_map;           // corner and size of the ground's map, cm

in vec3 v_world;
in vec2 v_slope;
centroid in float v_broad;
centroid in vec3 v_clear;
centroid in vec3 v_veil;

const vec3 PALE = vec3(0.62, 0.475, 0.30);
const vec3 TAN = vec3(0.33, 0.215, 0.11);
const vec3 FILM = vec3(0.17, 0.135, 0.06);  // algae
const vec3 ASH = vec3(0.17, 0.135, 0.11);    // old rubble
const vec3 SHELL = vec3(0.80, 0.73, 0.64);
const vec3 PINK = vec3(0.46, 0.20, 0.22);
const mat2 TURNED = mat2(0.80, 0.60, -0.60, 0.80);

void main() {
#ifdef FADING
    if (faded(u_fade)) discard;
#endif
    vec2 p = v_world.xy;
    vec2 at = (p - u_map.xy) / u_map.zw;
    vec4 ground = texture(u_ground, at);
#ifdef MOVING_SUN
    ground.x = dot(texture(u_early_suns, at), u_early) + dot(texture(u_late_suns, at), u_late);
#endif
    // Crests wind, and lie down in places.
    mat2 flow = mat2(u_flow, -u_flow.y, u_flow.x);
    vec2 wound = (p + v_broad * vec2(20.0, 26.0)) * flow;
    vec4 one = 6.0 * texture(u_ripples, wound / 173.0) - 3.0;
    vec4 bits = texture(u_litter, TURNED * p / 67.0);

#ifdef CLOSE_UP
    // Where one set of ripples is strong the other is weak.
    vec4 other = 6.0 * texture(u_ripples, TURNED * wound / 271.0 + 0.37) - 3.0;
    float share = smoothstep(-0.7, 0.9, v_broad + 0.25 * other.z);
    vec3 ripple = mix(one.xyz, vec3(other.xy * TURNED, other.z), share);
    float grain = one.w + other.w;
#else
    vec3 ripple = one.xyz;
    float grain = 1.5 * one.w;
#endif
    float rubble = ground.z;
    // From afar light that water has scattered softens them more than their haze tells.
    float strong = 0.5 + 0.5 * smoothstep(0.0, 0.3, v_clear.g);
    strong *= 0.75 + 0.25 * wave(vec2(0.62 * v_broad)).x;
    strong *= 1.0 - 0.6 * rubble;
    vec2 marks = flow * ripple.xy * strong;
    float height = ripple.z * strong;
    vec3 sand = mix(TAN, PALE, clamp(0.60 + 0.13 * v_broad + 0.20 * height + 0.075 * grain, 0.0, 1.0));
    sand = mix(sand, FILM, clamp(0.30 * smoothstep(0.2, 1.6, -v_broad) + 0.9 * rubble, 0.0, 0.85));

    // Bits are rare on open sand and crowded about stones.
    float lies = smoothstep(0.0, 0.12, bits.w - 0.93 + 0.93 * rubble);
    vec3 piece = bits.z < 0.55 ? ASH * (0.6 + 1.3 * bits.z) : mix(PINK, SHELL, 2.2 * bits.z - 1.2);
    sand = mix(sand, piece, 0.85 * lies);

#ifdef CLOSE_UP
    // Animals leave tracks where no swell has smoothed the sand since.
    vec4 track = 18.0 * texture(u_tracks, (p + 14.0 * v_broad) * TURNED / 197.0) - 9.0;
    float crossed = smoothstep(-0.2, 0.5, v_broad) * (1.0 - rubble) * (1.0 - lies);
    marks = marks * (1.0 - 0.5 * crossed * min(abs(track.z), 1.0)) + 0.24 * crossed * track.xy;
    sand *= 1.0 + 0.05 * crossed * clamp(0.25 * track.z, -1.0, 1.0);
#endif

    vec2 slope = v_slope + 0.46 * marks + (7.0 * bits.xy - 3.5) * (0.22 * lies);
    vec3 normal = normalize(vec3(-slope, 1.0));
    // Water scatters so much light forward that no shadow is black.
    float open = min(ground.x, unshaded(v_world));
    float lit = caustics_at(v_world) * open + 0.27 * (1.0 - open);
    vec3 light = SUNLIGHT * (lit * max(dot(normal, SUN), 0.0));
    light += mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal.z) * ground.y;
#ifdef LIT
    light += lamplight_on(v_world, normal, 0.1) / daylight(v_world.z);  // as that is in `v_clear`
#endif
    show(sand * light * v_clear, v_veil, v_clear / (EXPOSURE * daylight(v_world.z)), 1.0);
}
