// What host/microfacet/generator.cpp and generate.cl agree on.
// The planes of nodes h with their weight p(h) dw.
enum node_plane { NODE_X, NODE_Y, NODE_Z, NODE_WEIGHT, NODE_PLANES };
enum {
    VISIBLE_TILE = 8 // directions that a group of `visible` handles
};
// The sums of `reflect`: R at f0 = 0 and 1 with independent, then with correlated shadowing.
enum reflectance_sum { R0, R1, R0_CORRELATED, R1_CORRELATED, REFLECTANCE_SUMS };
