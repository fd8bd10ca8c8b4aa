#include "optics.glsl"

in vec3 a_position;
in float a_dark;  // share of the light that is missing

uniform mat4 u_view_projection;

out vec3 v_veil;
out float v_dark;

const float LIFT_CM = 4.0;  // toward the eye, off the sand that it lies on: seen flat it lies close

void main() {
    vec3 ray = a_position - u_eye;
    float distance = length(ray);
    v_veil = open_water(ray / distance) * (1.0 - clearness(distance));
    v_dark = a_dark;
    gl_Position = u_view_projection * vec4(a_position - LIFT_CM * ray / distance, 1.0);
}
