// A patch: one triangle that covers it, or a mesh that lies over it (MESH, view/rig.py).
#if MESH == 1
in vec2 in_place;
in vec4 in_seen;
in vec3 in_lit;  // where the place is lit, times w, and w (view/adjustment.py)
#endif
out vec2 v_place;
out vec4 v_seen;

void main() {
#if MESH == 1
    v_place = in_place;
    v_seen = in_seen;
    gl_Position = vec4(2.0 * in_lit.xy - in_lit.z, 0.0, in_lit.z);
#else
    v_place = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    v_seen = vec4(0.0);
    gl_Position = vec4(2.0 * v_place - 1.0, 0.0, 1.0);
#endif
}
