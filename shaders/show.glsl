// Output of a pixel: its colour, or with MARKS the object id of what hides at least half of what lies
// behind it, and the distance along the view.
#ifdef MARKS
#ifdef OWN_MARKS
flat in float v_mark;  // per vertex
#else
uniform float u_mark;
#define v_mark u_mark
#endif

out vec2 f_mark;  // object id; cm

void show(vec4 colour) {
    if (colour.a < 0.5) discard;
    f_mark = vec2(v_mark, 1.0 / gl_FragCoord.w);
}
#else
out vec4 f_colour;

void show(vec4 colour) {
    f_colour = colour;
}
#endif
