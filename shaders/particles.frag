#include "optics.glsl"

in vec3 v_world;
in float v_strength;

uniform vec3 u_colour;

out vec4 f_colour;

void main() {
    vec2 from_centre = gl_PointCoord * 2.0 - 1.0;
    float soft = max(1.0 - dot(from_centre, from_centre), 0.0);
    vec3 light = 0.35 * sunlight_at(v_world.z) + SKYLIGHT;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    vec3 colour = through_water(u_colour * light, ray / distance, distance);
    f_colour = vec4(colour, v_strength * soft * soft);
}
