// What every program of a view reads, in one buffer that is written once: `gl/shaders.py`.
layout(std140) uniform View {
    mat4 u_view;
    mat4 u_projection;
    mat4 u_view_projection;
    mat4 u_inverse;   // of projection and view
    vec3 u_eye;       // cm
    float u_time;     // s
    vec3 u_balance;   // the eye's, for light of each colour
    vec3 u_far;       // radiance of the far water, seen level
    vec3 u_broad;     // scattered forward about the sun: a broad glow
    vec3 u_narrow;    // and a narrow one
};
