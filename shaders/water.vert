#include "optics.glsl"

uniform ivec2 u_cells;   // across and down

out vec3 v_open;

// Clouds of plankton dim and brighten the water: noise of the places that one looks through.
float plankton(vec3 direction) {
    float sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        vec3 p = u_eye + (0.7 + 0.9 * float(k)) / u_extinction * direction + vec3(9.0, 5.0, 0.0) * u_time;
        sum += textureLod(u_noise, (p.xy + 0.7 * p.z) / 5200.0, 3.0).r;
        sum += textureLod(u_noise, (p.yz + 0.4 * p.x) / 3700.0, 3.0).r;
    }
    // Level with the ground things stand before the water, whose haze has no clouds.
    return clamp(1.0 + 0.05 * smoothstep(-0.15, 0.35, direction.z) * sum, 0.7, 1.35);
}

// A grid over the whole viewport at the far plane: the water is smooth,
// its vertices suffice.
void main() {
    ivec2 corner = ivec2(gl_VertexID % (u_cells.x + 1), gl_VertexID / (u_cells.x + 1));
    vec2 place = 2.0 * vec2(corner) / vec2(u_cells) - 1.0;
    vec4 far = u_inverse * vec4(place, 1.0, 1.0);
    vec3 direction = normalize(far.xyz / far.w - u_eye);
    v_open = open_water(direction) * plankton(direction) + glow(direction, 1e5);
    v_open *= u_unit;
    gl_Position = vec4(place, 1.0, 1.0);
}
