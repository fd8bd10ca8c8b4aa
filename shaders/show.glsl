// Output of a pixel: its light on the canvas, or with OBJECT_IDS the object id of what hides at least half of what lies
// behind it, the distance along the view, and the slopes of its inverse.
#ifdef OBJECT_IDS
#ifdef OWN_IDS
flat in float v_object_id;  // per vertex
#else
uniform float u_object_id;
#define v_object_id u_object_id
#endif

out vec4 f_object_id;  // object id; cm; change of 1 / cm to the right and up

void show(vec4 colour) {
    vec2 slope = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    if (colour.a < 0.5) discard;
    f_object_id = vec4(v_object_id, 1.0 / gl_FragCoord.w, slope);
}
#else
#ifdef INTEGERS
const float UNIT = 1.0 / 8.0;  // as u_unit; a software renderer reads a uniform for each pixel
#else
const float UNIT = 1.0;
#endif

out vec4 f_colour;

void show(vec4 colour) {
    f_colour = vec4(UNIT * colour.rgb, colour.a);
}
#endif
