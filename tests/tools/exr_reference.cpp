// SPDX-License-Identifier: Apache-2.0
// Prints what OpenEXR's C++ library reads of a file: a line for each part (its
// data window) and each channel (type, hash of its samples). Status 0 if the file
// is whole, else 4 and a line with the reason.
//
// A file is whole if every part is complete (no chunk is missing from a table),
// every line of every part is read without exception (of mipmaps, the largest),
// and every sample is from the file. The last is found by a second reading with
// memory filled otherwise: a chunk that holds less than its lines leaves the rest
// of OpenEXR's buffer unchanged without an exception.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <malloc.h>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Channel {
    std::string name;
    Imf::Channel as;
    std::vector<char> row; // of one line
    std::uint64_t hash = 14695981039346656037u;
};

// Returns the quotient rounded down, d > 0.
int below(int n, int d)
{
    return n >= 0 ? n / d : -((d - 1 - n) / d);
}

// FNV-1a, 8 bytes at a time for speed
void add(Channel &c)
{
    for (std::size_t i = 0; i < c.row.size(); i += sizeof c.hash) {
        std::uint64_t word = 0;
        std::memcpy(&word, c.row.data() + i,
                    std::min(sizeof word, c.row.size() - i));
        c.hash = (c.hash ^ word) * 1099511628211u;
        c.hash ^= c.hash >> 29;
    }
}

std::vector<Channel> channels_of(const Imf::Header &header)
{
    const Imath::Box2i data = header.dataWindow();
    std::vector<Channel> all;
    const Imf::ChannelList &list = header.channels();
    for (auto i = list.begin(); i != list.end(); ++i) {
        const int step = i.channel().xSampling;
        const std::size_t samples = static_cast<std::size_t>(
            below(data.max.x, step) - below(data.min.x, step) + 1);
        const std::size_t size = i.channel().type == Imf::HALF ? 2 : 4;
        all.push_back({i.name(), i.channel(),
                       std::vector<char>(samples * size)});
    }
    return all;
}

// One line at a time, so that a window of any height takes a line's memory.
std::string read_part(Imf::MultiPartInputFile &file, int number)
{
    Imf::InputPart part(file, number);
    const Imath::Box2i data = part.header().dataWindow();
    std::vector<Channel> all = channels_of(part.header());
    Imf::FrameBuffer buffer;
    for (Channel &c : all) {
        const std::ptrdiff_t size = c.as.type == Imf::HALF ? 2 : 4;
        buffer.insert(c.name, Imf::Slice(
            c.as.type,
            c.row.data() - size * below(data.min.x, c.as.xSampling),
            static_cast<std::size_t>(size), 0, c.as.xSampling,
            c.as.ySampling));
    }
    part.setFrameBuffer(buffer);
    for (int y = data.min.y; y <= data.max.y; y++) {
        part.readPixels(y);
        for (Channel &c : all) {
            if (y % c.as.ySampling == 0)
                add(c);
        }
    }
    std::string lines = "part " + std::to_string(number) + ":";
    for (const int v : {data.min.x, data.min.y, data.max.x, data.max.y})
        lines += " " + std::to_string(v);
    for (const Channel &c : all)
        lines += "\n" + c.name + " " + std::to_string(c.as.type) + " " +
                 std::to_string(c.hash);
    return lines + "\n";
}

std::string read_file(const char *path, int filled_with)
{
    mallopt(M_PERTURB, filled_with);
    Imf::MultiPartInputFile file(path);
    std::string lines;
    for (int i = 0; i < file.parts(); i++) {
        const Imf::Header &header = file.header(i);
        if (header.hasType() && Imf::isDeepData(header.type()))
            throw std::runtime_error("deep");
        if (!file.partComplete(i))
            throw std::runtime_error("incomplete: chunks are missing");
    }
    for (int i = 0; i < file.parts(); i++)
        lines += read_part(file, i);
    return lines;
}

} // namespace

int main(int argc, char **argv)
try {
    if (argc != 2) {
        std::fprintf(stderr, "usage: exr_reference FILE\n");
        return 2;
    }
    const std::string lines = read_file(argv[1], 0); // not filled
    for (const int fill : {0x55, 0xaa}) {
        if (read_file(argv[1], fill) != lines)
            throw std::runtime_error("samples that no chunk holds: OpenEXR "
                                     "gives what was in memory");
    }
    std::fputs(lines.c_str(), stdout);
    return 0;
} catch (const std::exception &e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 4;
}
