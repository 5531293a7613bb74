/* Finds the last block of a deflate stream without unpacking it.
 *
 * A block says whether it is the last where it begins, but nowhere how long it
 * is. So blocks before the last are decoded, but for the lengths of their
 * symbols only: an entry of a table is the bits that a symbol takes with its
 * extra bits, or those of several literals. The last block ends in the last
 * byte, with the symbol for its end: where that is found there once, the block
 * need not be decoded.
 * Source: RFC 1951, section 3.2. */
#include "io/io_priv.h"

#include <string.h>

enum {
    LITLEN_BITS = 11, DIST_BITS = 9, // of tables; longer codes are rare
    LONGEST = 15,                    // bits of a code
    SYMBOLS = 288, LENGTHS = SYMBOLS + 32,
    STOP = 256,                      // symbol at the end of a block
};

/* Entries of tables: bits to skip, and a kind. */
enum {
    LITERALS = 0, MATCH = 1 << 6, END = 2 << 6, LONG = 3 << 6,
    KIND = 3 << 6, BITS = (1 << 6) - 1,
};

// -- bits ---------------------------------------------------------------------

struct bits {
    const uint8_t *data;
    size_t n, at;       // bytes; at: that were taken into `held`
    uint64_t held;      // the next `left` bits, from the lowest
    unsigned left;
};

/* At least 56 bits are held then; 0 after the end of the data. */
static inline void refill(struct bits *b)
{
    uint64_t next = 0;
    if (b->n >= sizeof next && b->at <= b->n - sizeof next) {
        memcpy(&next, b->data + b->at, sizeof next);
    } else {
        for (size_t i = 0; i < sizeof next && b->at + i < b->n; i++)
            next |= (uint64_t) b->data[b->at + i] << 8 * i;
    }
    b->held |= next << b->left;
    b->at += (63 - b->left) >> 3;
    b->left |= 56;
}

static inline unsigned peek(const struct bits *b, unsigned n)
{
    return (unsigned) (b->held & ((1u << n) - 1));
}

static inline void skip(struct bits *b, unsigned n)
{
    b->held >>= n;
    b->left -= n;
}

static unsigned take(struct bits *b, unsigned n)
{
    const unsigned v = peek(b, n);
    skip(b, n);
    return v;
}

static size_t position(const struct bits *b)
{
    return 8 * b->at - b->left;
}

static bool is_past_end(const struct bits *b)
{
    return position(b) > 8 * b->n;
}

// -- codes --------------------------------------------------------------------

/* A canonical code: symbols in the order of their codes. */
struct code {
    uint16_t count[LONGEST + 1]; // of each length; 0 for length 0
    uint16_t symbol[SYMBOLS];
};

static void make_code(struct code *c, const uint8_t *length, int n)
{
    uint16_t at[LONGEST + 1] = {0};
    *c = (struct code) {0};
    for (int i = 0; i < n; i++)
        c->count[length[i]]++;
    c->count[0] = 0;
    for (int i = 1; i < LONGEST; i++)
        at[i + 1] = (uint16_t) (at[i] + c->count[i]);
    for (int i = 0; i < n; i++) {
        if (length[i])
            c->symbol[at[length[i]]++] = (uint16_t) i;
    }
}

/* A code's bits as they follow each other in a stream, from the lowest. */
static unsigned reversed(unsigned code, unsigned n)
{
    unsigned r = 0;
    for (unsigned i = 0; i < n; i++)
        r |= (code >> i & 1) << (n - 1 - i);
    return r;
}

/* Returns the symbol that the next bits are, and its length; -1 for none. */
static int decode(const struct code *c, const struct bits *b, unsigned *length)
{
    unsigned code = 0, first = 0, index = 0;
    for (unsigned n = 1; n <= LONGEST; n++) {
        code |= (unsigned) (b->held >> (n - 1)) & 1;
        if (code - first < c->count[n]) {
            *length = n;
            return c->symbol[index + code - first];
        }
        index += c->count[n];
        first = (first + c->count[n]) << 1;
        code <<= 1;
    }
    return -1;
}

static uint8_t litlen_entry(unsigned symbol, unsigned length)
{
    static const uint8_t extra[SYMBOLS - STOP - 1] = {
        0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2,
        3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5,
    };
    return (uint8_t) (symbol < STOP    ? length // kind LITERALS
                      : symbol == STOP ? END | length
                      : MATCH | (length + extra[symbol - STOP - 1]));
}

static uint8_t dist_entry(unsigned symbol, unsigned length)
{
    return (uint8_t) (MATCH | (length + (symbol < 4 ? 0 : symbol / 2 - 1)));
}

/* Fills a table, by the next `bits` bits of the stream. */
static void make_table(const struct code *c, unsigned bits, uint8_t *table,
                       uint8_t (*entry)(unsigned symbol, unsigned length))
{
    unsigned code = 0;
    const uint16_t *symbol = c->symbol;
    memset(table, LONG, (size_t) 1 << bits);
    for (unsigned n = 1; n <= bits; n++, code <<= 1) {
        for (int i = 0; i < c->count[n]; i++, code++) {
            const uint8_t e = entry(*symbol++, n);
            for (unsigned k = reversed(code, n); k < 1u << bits; k += 1u << n)
                table[k] = e;
        }
    }
}

/* Makes an entry of all literals that begin a table's index. */
static void join_literals(uint8_t table[1 << LITLEN_BITS])
{
    uint8_t one[1 << LITLEN_BITS];
    memcpy(one, table, sizeof one);
    for (unsigned i = 0; i < sizeof one; i++) {
        unsigned used = 0, next = one[i];
        while ((next & KIND) == LITERALS && used + next <= LITLEN_BITS) {
            used += next;
            next = one[i >> used];
        }
        table[i] = used ? (uint8_t) used : table[i];
    }
}

// -- blocks -------------------------------------------------------------------

struct codes {
    struct code litlen, dist;
};

static void make_fixed_codes(struct codes *c)
{
    uint8_t length[SYMBOLS];
    memset(length, 8, 144);
    memset(length + 144, 9, 112);
    memset(length + 256, 7, 24);
    memset(length + 280, 8, 8);
    make_code(&c->litlen, length, SYMBOLS);
    memset(length, 5, 30);
    make_code(&c->dist, length, 30);
}

/* Reads the codes of a block; false where they are damaged. */
static bool read_codes(struct bits *b, struct codes *c)
{
    static const uint8_t order[19] = {
        16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15,
    };
    uint8_t length[LENGTHS] = {0};
    struct code lengths;
    const int litlens = (int) take(b, 5) + 257, dists = (int) take(b, 5) + 1;
    const int orders = (int) take(b, 4) + 4;
    for (int i = 0; i < orders; i++) {
        refill(b);
        length[order[i]] = (uint8_t) take(b, 3);
    }
    make_code(&lengths, length, (int) sizeof order);
    memset(length, 0, sizeof length);
    for (int i = 0, n; i < litlens + dists; i += n) {
        unsigned bits;
        refill(b);
        const int symbol = decode(&lengths, b, &bits);
        if (symbol < 0 || is_past_end(b))
            return false;
        skip(b, bits);
        n = symbol < 16    ? 1
            : symbol == 16 ? 3 + (int) take(b, 2)
            : symbol == 17 ? 3 + (int) take(b, 3) : 11 + (int) take(b, 7);
        if (i + n > litlens + dists || (symbol == 16 && i == 0))
            return false;
        const int v = symbol < 16 ? symbol : symbol == 16 ? length[i - 1] : 0;
        memset(length + i, v, (size_t) n);
    }
    make_code(&c->litlen, length, litlens);
    make_code(&c->dist, length + litlens, dists);
    return true;
}

/* Skips the symbols of a block; false where they are damaged. */
static bool skip_symbols(struct bits *b, const struct codes *c)
{
    uint8_t litlen[1 << LITLEN_BITS], dist[1 << DIST_BITS];
    make_table(&c->litlen, LITLEN_BITS, litlen, litlen_entry);
    make_table(&c->dist, DIST_BITS, dist, dist_entry);
    join_literals(litlen);
    while (!is_past_end(b)) {
        unsigned bits;
        int symbol;
        refill(b);
        uint8_t e = litlen[peek(b, LITLEN_BITS)];
        for (int i = 0; i < 2 && (e & KIND) == LITERALS; i++) {
            skip(b, e);
            e = litlen[peek(b, LITLEN_BITS)];
        }
        refill(b); // 20 bits at most for a length, and 28 for its distance
        if (e == LONG) {
            symbol = decode(&c->litlen, b, &bits);
            if (symbol < 0)
                return false;
            e = litlen_entry((unsigned) symbol, bits);
        }
        skip(b, e & BITS);
        if ((e & KIND) == END)
            return !is_past_end(b);
        if ((e & KIND) == LITERALS)
            continue;
        e = dist[peek(b, DIST_BITS)];
        if (e == LONG) {
            symbol = decode(&c->dist, b, &bits);
            if (symbol < 0)
                return false;
            e = dist_entry((unsigned) symbol, bits);
        }
        skip(b, e & BITS);
    }
    return false;
}

static bool skip_stored(struct bits *b)
{
    const size_t at = (position(b) + 7) / 8;
    if (at + 4 > b->n)
        return false;
    const size_t size = b->data[at] | (size_t) b->data[at + 1] << 8;
    *b = (struct bits) {.data = b->data, .n = b->n, .at = at + 4 + size};
    return !is_past_end(b);
}

/* Finds where a last block ends, in bits: returns true where the code of its
 * end is at one place of the last byte only. */
static bool find_end(const struct bits *b, const struct code *litlen,
                     size_t *end)
{
    unsigned code = 0, length = 0, found = 0;
    const uint16_t *symbol = litlen->symbol;
    for (unsigned n = 1; n <= LONGEST && !length; n++) {
        code <<= 1;
        for (int i = 0; i < litlen->count[n] && !length; i++, code++) {
            if (*symbol++ == STOP)
                length = n;
        }
    }
    const unsigned stop = length ? reversed(code - 1, length) : 0;
    for (unsigned unused = 0; length && unused < 8; unused++) {
        const size_t to = 8 * b->n - unused, from = to - length;
        unsigned bits = 0;
        if (to < position(b) + length)
            break;
        for (size_t i = 0; i < 3 && from / 8 + i < b->n; i++)
            bits |= (unsigned) b->data[from / 8 + i] << 8 * i;
        if ((bits >> from % 8 & ((1u << length) - 1)) == stop) {
            *end = to;
            found++;
        }
    }
    return found == 1;
}

bool gp_deflate_last_block(const uint8_t *data, size_t n, size_t *begin,
                           size_t *end)
{
    struct bits b = {.data = data, .n = n};
    struct codes c;
    for (bool last = false; !last;) {
        refill(&b);
        *begin = position(&b);
        last = take(&b, 1);
        const unsigned type = take(&b, 2);
        if (type == 3 || is_past_end(&b))
            return false;
        if (type == 0 && !skip_stored(&b))
            return false;
        if (type == 0)
            continue;
        if (type == 1)
            make_fixed_codes(&c);
        else if (!read_codes(&b, &c))
            return false;
        if (last && find_end(&b, &c.litlen, end))
            return true;
        if (!skip_symbols(&b, &c))
            return false;
    }
    *end = position(&b);
    return true;
}
