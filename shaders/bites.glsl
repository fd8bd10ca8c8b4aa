// Where fishes have eaten growth: spots that fade as it grows again. Only what one of them may lie on
// is drawn with BITTEN: going through them for each pixel takes a software renderer a fifth of a picture.
#ifdef BITTEN
const int BITES = 16;
uniform vec4 u_bites[BITES];  // place, cm, and the share that is gone
uniform int u_bitten;         // how many there are

// The share of the growth that is gone at a point.
float bitten(vec3 p) {
    float gone = 0.0;
    for (int k = 0; k < u_bitten; k++) {
        vec3 off = p - u_bites[k].xyz;
        gone = max(gone, u_bites[k].w * (1.0 - smoothstep(2.5, 7.0, length(off))));
    }
    return gone;
}
#else
float bitten(vec3 p) { return 0.0; }
#endif
