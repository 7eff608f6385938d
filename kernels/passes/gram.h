// Rows a group multiplies with as many: fit/search.cpp, gram.cl.
enum { GRAM_TILE = 4 };
