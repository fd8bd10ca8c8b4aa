// The mouth of a fish: where it is on the skin, and how far it is open.

const float LIFT = 0.4;  // of the border between the jaws above the line between its ends, shares
                         // of half the border's width

// How far a place is behind the tip of the mouth, lengths of the mouth, and how far above the
// middle of the border between the jaws, shares of half its width.
vec2 at_mouth(vec2 rest, int kind) {
    vec4 mouth = looks[kind].mouth;
    vec2 reach = mouth.zw - mouth.xy;
    float behind = (rest.x - mouth.x) / reach.x;
    return vec2(behind, (rest.y - mouth.y - behind * reach.y) / looks[kind].jaws.y - LIFT);
}

// The angle by which the lower jaw is turned, rad: a breath hardly shows, a bite does.
float opening(float gape, int kind) {
    return gape * gape * looks[kind].jaws.x;
}
