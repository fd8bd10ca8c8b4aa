#include "optics.glsl"

in vec3 a_position;

uniform mat4 u_view_projection;
uniform mat4 u_projection;
uniform vec2 u_size;     // pixels of the viewport
uniform float u_diameter;  // cm
uniform float u_box;     // cm; 0: positions are the world's, else shares of a box about the eye
uniform float u_reach;   // cm; specks have faded there
uniform vec3 u_drift;    // cm/s, of the boxed specks
uniform vec3 u_colour;

out vec4 v_colour;

void main() {
    vec3 world = a_position;
    if (u_box > 0.0) {
        vec3 place = a_position * u_box + u_drift * u_time;
        place.xy += 6.0 * sin(u_time * vec2(0.31, 0.23) + a_position.yx * 40.0);
        world = u_eye + mod(place - u_eye, u_box) - 0.5 * u_box;
    }
    gl_Position = u_view_projection * vec4(world, 1.0);
    float size = u_diameter * (0.6 + 0.8 * fract(a_position.x * 91.7 + float(gl_VertexID) * 0.618));
    float pixels = size * u_projection[1][1] * u_size.y * 0.5 / max(gl_Position.w, 1.0);
    // A speck smaller than a few pixels keeps their area and loses strength instead.
    gl_PointSize = clamp(pixels, 2.0, 24.0);
    float share = clamp(pixels / gl_PointSize, 0.0, 1.0);
    vec3 ray = world - u_eye;
    float distance = length(ray);
    vec3 clear = clearness(distance);
    vec3 light = 0.35 * sunlight_at(world.z) + SKYLIGHT;
    vec3 colour = u_colour * light * clear + water_radiance(ray / distance) * (1.0 - clear);
    float strength = share * share * (1.0 - smoothstep(0.6 * u_reach, u_reach, distance))
        * smoothstep(6.0, 30.0, distance) * step(world.z, 0.0);
    v_colour = vec4(colour, strength);
}
