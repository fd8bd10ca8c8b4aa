// Where fishes have eaten growth: spots that fade as it grows again.
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
