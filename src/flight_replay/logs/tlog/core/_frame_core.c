/* What reading a telemetry log spends its time in, done as frame_search.py, nested_frames.py and
   frames.py do it with numpy, to the same results. No Python in here: frame_core.py calls it by ctypes.

   Bytes are compared in plain loops over a piece that stays in the first cache, of which compilers
   make vector instructions. The log is only read byte by byte, so nothing needs to be aligned. */

#include <stdint.h>
#include <string.h>

#define FIRST(word) (__builtin_ctzll(word) >> 3)

enum { PIECE = 2048, WORD = 8 }; /* bytes */
enum { MAVLINK1 = 0xFE, MAVLINK2 = 0xFD, SIGNED = 1, SIGNATURE = 13, OVERHEAD2 = 12 };

/* The same loops for wider vectors, chosen when the library is loaded, where compiler and C library can. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

/* Flag the bytes that begin a header with one of three message ids. */
WIDE static void flag_headers(const uint8_t *restrict data, const uint8_t *ids, uint8_t *restrict flags)
{
    uint8_t wanted[PIECE + WORD];
    const uint8_t first = ids[0], second = ids[1], third = ids[2];
    for (int at = 0; at < PIECE + WORD; at++)
        wanted[at] = (uint8_t)((data[at] == first) | (data[at] == second) | (data[at] == third));
    for (int at = 0; at < PIECE; at++)
        flags[at] = (uint8_t)(((data[at] == MAVLINK1) & wanted[at + 5]) |
                              ((data[at] == MAVLINK2) & wanted[at + 7]));
}

/* Flag the start bytes with a payload that may reach the end of the bytes. */
WIDE static void flag_long(const uint8_t *restrict data, const uint8_t *restrict shortest1,
                      const uint8_t *restrict shortest2, uint8_t *restrict flags, int length)
{
    for (int at = 0; at < length; at++)
        flags[at] = (uint8_t)(((data[at] == MAVLINK1) & (data[at + 1] >= shortest1[at])) |
                              ((data[at] == MAVLINK2) & (data[at + 1] >= shortest2[at])));
}

/* A word of flags, each 0 or 1: the lowest byte is the first one. */
static uint64_t word_of(const uint8_t *flags)
{
    uint64_t word;
    memcpy(&word, flags, WORD);
    return word;
}

/* The number of the message, from 1, that a header may be of; 0 for none. */
static int number_of(const uint8_t *header, const uint8_t *by_shape, const uint8_t *by_id)
{
    if (header[0] == MAVLINK1)
        return by_shape[header[5] << 8 | header[1]];
    return header[2] <= SIGNED && !header[8] && !header[9] ? by_id[header[7]] : 0;
}

/* Where frames of up to three messages may begin in some bytes, which ten others follow.
   Message by message, first what is none: `starts` has room for `length` of each, `counts` says how many there are. */
void find_headers(const uint8_t *data, int64_t length, const uint8_t *ids, const uint8_t *by_shape,
                  const uint8_t *by_id, int64_t *starts, int64_t *counts)
{
    uint8_t flags[PIECE], last[PIECE + WORD] = {0};
    for (int64_t piece = 0; piece < length; piece += PIECE) {
        const int64_t size = length - piece < PIECE ? length - piece : PIECE;
        const uint8_t *bytes = size < PIECE ? memcpy(last, data + piece, (size_t)size + WORD) : data + piece;
        flag_headers(bytes, ids, flags);
        memset(flags + size, 0, (size_t)(PIECE - size));
        for (int64_t word = 0; word < size; word += WORD)
            for (uint64_t left = word_of(flags + word); left; left &= left - 1) {
                const int64_t at = piece + word + FIRST(left);
                const int number = number_of(data + at, by_shape, by_id);
                starts[number * length + counts[number]++] = at;
            }
    }
}

/* Whether a frame may reach a byte so many behind its first one, by most of its header. */
static int may_reach(const uint8_t *header, int64_t distance, const uint8_t *shapes)
{
    if (header[0] == MAVLINK1)
        return shapes[header[5] << 8 | header[1]];
    return header[2] <= SIGNED && header[1] + OVERHEAD2 + SIGNATURE * header[2] > distance;
}

/* What may be frames around places (n,), by the `reach` (280) bytes up to each: returns how many pairs. */
int64_t find_enclosures(const uint8_t *data, const int64_t *places, int64_t n, int64_t reach,
                        const uint8_t *shortest1, const uint8_t *shortest2, const uint8_t *shapes,
                        int64_t *starts, int64_t *around)
{
    int64_t count = 0;
    uint8_t flags[PIECE] = {0};
    for (int64_t each = 0; each < n; each++) {
        const int64_t first = places[each] - reach + 1;
        flag_long(data + first, shortest1, shortest2, flags, (int)reach - 1);
        for (int64_t word = 0; word < reach; word += WORD)
            for (uint64_t left = word_of(flags + word); left; left &= left - 1) {
                const int64_t at = word + FIRST(left);
                starts[count] = first + at;
                around[count] = places[each];
                count += may_reach(data + first + at, reach - 1 - at, shapes);
            }
    }
    return count;
}

/* The checksum of bytes and the CRC extra, by what a byte adds that 0, 1, 2 or 3 others follow. */
static uint16_t crc_of(const uint8_t *bytes, int length, int extra, const uint16_t (*adds)[256])
{
    uint16_t crc = 0xFFFF;
    for (; length >= 4; length -= 4, bytes += 4)
        crc = adds[3][(bytes[0] ^ crc) & 255] ^ adds[2][bytes[1] ^ crc >> 8] ^ adds[1][bytes[2]] ^ adds[0][bytes[3]];
    for (; length > 0; length--, bytes++)
        crc = (uint16_t)(crc >> 8 ^ adds[0][(*bytes ^ crc) & 255]);
    return (uint16_t)(crc >> 8 ^ adds[0][(extra ^ crc) & 255]);
}

/* Whether the CRCs of frames (n,) that begin in some bytes are valid; none is of a frame that leaves them. */
void check_frames(const uint8_t *data, int64_t length, const int64_t *starts, int64_t n, const int16_t *extras,
                  const uint16_t (*adds)[256], uint8_t *valid)
{
    for (int64_t each = 0; each < n; each++) {
        const int64_t left = length - starts[each];
        const uint8_t *frame = data + starts[each];
        const int header = left < 8 ? 0 : frame[0] == MAVLINK1 ? 6 : left < 12 ? 0 : 10;
        const int message = header == 6 ? frame[5] : header == 10 ? frame[7] | frame[8] << 8 : 0;
        const int crc_at = header + (header ? frame[1] : 0);
        valid[each] = header && extras[message] >= 0 && crc_at + 2 <= left &&
                      crc_of(frame + 1, crc_at - 1, extras[message], adds) ==
                          (frame[crc_at] | frame[crc_at + 1] << 8);
    }
}
