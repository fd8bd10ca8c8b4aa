// Cross-fade of two levels of detail: each pixel belongs to exactly one of both.
uniform float u_fade;  // of a whole drawing call

// A share f > 0 is drawn in the first f of an even pattern, f < 0 in the last -f, 0 everywhere.
bool faded(float share) {
    // Interleaved gradient noise: even, and without a pattern that shows (Jimenez).
    float at = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    return share > 0.0 ? at >= share : share < 0.0 && at < 1.0 + share;
}
