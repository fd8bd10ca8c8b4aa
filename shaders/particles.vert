// Specks in the water: marine snow about the eye, and plankton. Both shine toward the light, blur
// out of focus and are drawn out along the way that they have moved while the picture was exposed.
#include "optics.glsl"

in vec3 a_position;

uniform vec2 u_size;     // pixels of the viewport
uniform float u_diameter;  // cm, of the largest
uniform float u_box;     // cm; 0: positions are the world's, else shares of a box about the eye
uniform float u_reach;   // cm; specks have faded there
uniform vec3 u_drift;    // cm/s, of the boxed specks
uniform vec3 u_passing;  // cm/s, of the eye
uniform vec3 u_colour;

out vec4 v_colour;
#ifdef PASSES
flat out vec3 v_veil;
flat out vec3 v_clear;
#endif
#ifdef CLOSE_UP
flat out vec4 v_form;  // axis on the sprite; number of its shape, and how plainly that shows
#endif
flat out vec2 v_streak;  // half the way that it has moved, and its radius, shares of the sprite
flat out float v_radius;

const float EXPOSED = 0.02;    // s
const float APERTURE = 0.5;    // cm
const float FOCUSED = 220.0;   // cm
const float LARGEST = 40.0;    // pixels, of a sprite
#ifdef CLOSE_UP
const float LEAST = 3.0;       // pixels: fewer would be a square
#else
const float LEAST = 2.0;
#endif
const vec2 NEAR = vec2(12.0, 42.0);  // cm, from where to where a speck before the eye is seen
const float BACK = 0.16, FORWARD = 0.9;  // share of sunlight that it sends back, and on

void main() {
    float number = fract(float(gl_VertexID) * 0.618034), chance = fract(a_position.x * 91.7 + number);
    vec3 world = a_position, moved = -u_passing;
    float glint = 1.0;
    if (u_box > 0.0) {
        vec3 place = a_position * u_box + u_drift * u_time;
        place.xy += 6.0 * sin(u_time * vec2(0.31, 0.23) + a_position.yx * 40.0);
        world = u_eye + mod(place - u_eye, u_box) - 0.5 * u_box;
        moved += u_drift;
        chance *= chance;
    } else {
        // It hops, sinks back, and glints as it turns.
        float beat = u_time * (0.35 + 0.5 * number) + 6.0 * number;
        float hop = smoothstep(0.0, 0.12, fract(beat)) - fract(beat);
        float way = 40.0 * floor(beat) + 9.0 * number;
        world += 1.6 * hop * vec3(sin(way), cos(1.3 * way), 0.6 * sin(2.1 * way));
        glint = 0.55 + 0.45 * sin(u_time * (2.0 + 5.0 * number) + 40.0 * number);
    }
    gl_Position = u_view_projection * vec4(world, 1.0);
    vec3 ray = world - u_eye;
    float distance = length(ray);
    float scale = u_projection[1][1] * u_size.y * 0.5;  // pixels of a radian
    float pixels = u_diameter * (0.22 + 0.78 * chance * chance) * scale / max(distance, 1.0);
    float blurred = pixels + APERTURE * abs(1.0 / distance - 1.0 / FOCUSED) * scale;
    // A speck smaller than a few pixels keeps the light that it sends and loses strength instead.
    float width = clamp(blurred, LEAST, 0.5 * LARGEST);
#ifdef CLOSE_UP
    // Shapes tumble; they need more room than a round speck.
    vec3 lot = fract(vec3(13.1, 37.7, 71.3) * (a_position.x + number));
    float spin = u_time * (0.2 + 0.5 * lot.z), tilt = 6.2832 * lot.y + (u_box > 0.0 ? spin : 0.4 * sin(spin));
    vec3 axis = normalize(vec3(cos(tilt), sin(tilt), 1.6 * lot.x - 0.8));
    vec4 tip = u_view_projection * vec4(world + axis, 1.0);
    vec2 lies = (tip.xy / max(tip.w, 1.0) - gl_Position.xy / max(gl_Position.w, 1.0)) * u_size;
    float plain = smoothstep(3.0, 7.0, pixels) * clamp(2.0 * pixels / blurred - 0.5, 0.0, 1.0);
    float form = (u_box > 0.0 ? 0.0 : 4.0) + floor(4.0 * lot.z);
    v_form = vec4(vec2(lies.x, -lies.y) * inversesqrt(dot(lies, lies) + 1e-6), form, plain);
    width = min(width * (1.0 + 0.9 * plain), 0.5 * LARGEST);
#endif
    vec4 before = u_view_projection * vec4(world - EXPOSED * moved, 1.0);
    vec2 streak = gl_Position.xy / max(gl_Position.w, 1.0) - before.xy / max(before.w, 1.0);
    streak *= 0.5 * u_size;
    float length_ = length(streak);
    streak *= min(length_, LARGEST - width) / max(length_, 1e-4);
    length_ = length(streak);
    gl_PointSize = width + length_;
    v_streak = vec2(streak.x, -streak.y) / gl_PointSize;
    v_radius = width / gl_PointSize;
    float share = min(pixels * pixels / (width * width), 1.0);
    share = mix(share, sqrt(share), 0.35) * width / (width + 0.8 * length_);

    vec3 look = ray / distance;
    vec3 clear = clearness(distance);
    float toward = max(dot(look, SUN), 0.0);
    vec3 light = (BACK + FORWARD * toward * toward) * sunlight_at(world.z) + SKYLIGHT * daylight(world.z)
        + lamplight_at(world);
    vec3 colour = u_colour * glint * light * clear, veil = water_radiance(look) * (1.0 - clear);
    float strength = share * (1.0 - smoothstep(0.6 * u_reach, u_reach, distance))
        * smoothstep(NEAR.x, NEAR.y, distance) * step(world.z, 0.0);
#ifdef PASSES
    v_colour = vec4(colour, strength);
    v_veil = veil;
    v_clear = clear;
#else
    v_colour = vec4(u_unit * (colour + veil), strength);
#endif
}
