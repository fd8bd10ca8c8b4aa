// What every program of a view reads, in one buffer that is written once: `gl/shaders.py`.
// A page in a browser sets its members one by one (`export/web.py`).
#ifdef PAGE
#define MEMBER uniform
#else
#define MEMBER
layout(std140) uniform View {
#endif
    MEMBER mat4 u_view;
    MEMBER mat4 u_projection;
    MEMBER mat4 u_view_projection;
    MEMBER mat4 u_inverse;   // of projection and view
    MEMBER vec3 u_eye;       // cm
    MEMBER float u_time;     // s
    MEMBER vec3 u_balance;   // the eye's, for light of each colour
    MEMBER vec3 u_far;       // radiance of the far water, seen level
    MEMBER vec3 u_broad;     // scattered forward about the sun: a broad glow
    MEMBER vec3 u_narrow;    // and a narrow one
    MEMBER float u_unit;     // of light on the canvas: what is written for a light of 1
#ifndef PAGE
};
#endif
