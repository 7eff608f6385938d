#include "host/image/image.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/image/exr_header.hpp"
#include "host/image/limits.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

class BytesIn : public Imf::IStream {
  public:
    explicit BytesIn(const MappedFile& file) : IStream(file.path().c_str()), bytes_(file.bytes()) {}
    bool read(char c[], int n) override {
        if (n < 0 || static_cast<std::size_t>(n) > bytes_.size() - at_)
            throw InputError("the file ends early");
        std::memcpy(c, bytes_.data() + at_, static_cast<std::size_t>(n));
        at_ += static_cast<std::size_t>(n);
        return at_ < bytes_.size();
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t position) override {
        if (position > bytes_.size())
            throw InputError("the file ends early");
        at_ = static_cast<std::size_t>(position);
    }

  private:
    std::string_view bytes_;
    std::size_t at_ = 0;
};

class BytesOut : public Imf::OStream {
  public:
    explicit BytesOut(const std::string& path) : OStream(path.c_str()) {}
    void write(const char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        bytes_.resize(std::max(bytes_.size(), at_ + count));
        std::memcpy(bytes_.data() + at_, c, count);
        at_ += count;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t position) override { at_ = static_cast<std::size_t>(position); }
    std::string_view bytes() const { return bytes_; }

  private:
    std::string bytes_;
    std::size_t at_ = 0;
};

std::map<std::string, std::string> string_attributes(const Imf::Header& header) {
    std::map<std::string, std::string> found;
    for (auto a = header.begin(); a != header.end(); ++a)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
            found[a.name()] = text->value();
    found.erase("type"); // the kind of part, not metadata
    return found;
}

Image read_part(Imf::MultiPartInputFile& input, int number) {
    const Imf::Header& header = input.header(number);
    if (header.hasType() && !Imf::isImage(header.type()))
        throw InputError(fmt::format("part {} is deep; expected a flat image", number));
    const Imath::Box2i window = header.dataWindow();
    Image image;
    image.width = static_cast<std::size_t>(std::int64_t{window.max.x} - window.min.x + 1);
    image.height = static_cast<std::size_t>(std::int64_t{window.max.y} - window.min.y + 1);
    image.metadata = string_attributes(header);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            throw InputError(fmt::format(
                "channel {} is subsampled; expected a value for every pixel", c.name()));
        image.channels.emplace_back(c.name());
    }

    Imf::FrameBuffer frame;
    for (const std::string& channel : image.channels) {
        std::vector<float>& plane = image.planes.emplace_back(image.width * image.height);
        frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, plane.data(), window));
    }
    Imf::InputPart part(input, number);
    part.setFrameBuffer(frame);
    part.readPixels(window.min.y, window.max.y);
    return image;
}

// The first `most` parts.
std::vector<Image> read_parts(const std::string& path, int most) {
    const MappedFile file(path);
    try {
        check_exr_headers(file.bytes());
        BytesIn stream(file);
        Imf::MultiPartInputFile input(stream, 0);
        std::vector<Image> images;
        std::size_t values = 0;
        for (int k = 0; k < std::min(most, input.parts()); ++k) {
            images.push_back(read_part(input, k));
            const Image& image = images.back();
            values += image.width * image.height * image.channels.size();
            check_image_size(values, 1, 1, file.bytes().size());
        }
        return images;
    } catch (const std::exception& e) {
        throw InputError(fmt::format("{}: not a readable OpenEXR image: {}", path, e.what()));
    }
}

// Header, pixels and what holds them until they are written.
struct Outgoing {
    Imf::Header header;
    Imf::FrameBuffer frame;
    std::vector<std::vector<half>> halves;
};

void prepare(const Image& image, const std::string& path, ExrPixel pixel, Outgoing& out) {
    constexpr auto most = static_cast<std::size_t>(std::numeric_limits<int>::max());
    std::vector<std::string> names = image.channels;
    std::sort(names.begin(), names.end());
    const bool fits = std::all_of(image.planes.begin(), image.planes.end(), [&](const auto& plane) {
        return plane.size() == image.width * image.height;
    });
    if (!fits || image.planes.size() != names.size() || names.empty() || image.width == 0 ||
        image.height == 0 || image.width > most || image.height > most ||
        std::adjacent_find(names.begin(), names.end()) != names.end())
        throw UsageError(
            fmt::format("{}: an image of {} x {} must have distinct channels, each with a "
                        "plane of that size",
                        path, image.width, image.height));
    out.header = Imf::Header(static_cast<int>(image.width), static_cast<int>(image.height));
    out.header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [name, text] : image.metadata)
        out.header.insert(name, Imf::StringAttribute(text));
    out.halves.reserve(image.channels.size());
    for (std::size_t ch = 0; ch < image.channels.size(); ++ch) {
        const bool half_float = pixel == ExrPixel::Half;
        out.header.channels().insert(image.channels[ch],
                                     Imf::Channel(half_float ? Imf::HALF : Imf::FLOAT));
        const std::vector<float>& plane = image.planes[ch];
        if (half_float)
            out.halves.emplace_back(plane.begin(), plane.end());
        void* const data = half_float ? static_cast<void*>(out.halves.back().data())
                                      : const_cast<float*>(plane.data()); // only read
        out.frame.insert(image.channels[ch], Imf::Slice::Make(half_float ? Imf::HALF : Imf::FLOAT,
                                                              data, out.header.dataWindow()));
    }
}

void save(const BytesOut& stream, const std::string& path) {
    OutputFile file(path);
    file.write(stream.bytes());
    file.commit();
}

} // namespace

const std::vector<float>* Image::plane(const std::string& channel) const {
    const auto found = std::find(channels.begin(), channels.end(), channel);
    return found == channels.end() ? nullptr
                                   : &planes[static_cast<std::size_t>(found - channels.begin())];
}

Image read_exr(const std::string& path) {
    return std::move(read_parts(path, 1).front());
}

std::vector<Image> read_exr_parts(const std::string& path) {
    return read_parts(path, std::numeric_limits<int>::max());
}

void write_exr(const Image& image, const std::string& path, ExrPixel pixel) {
    Outgoing out;
    prepare(image, path, pixel, out);
    BytesOut stream(path);
    try {
        Imf::OutputFile output(stream, out.header, 0);
        output.setFrameBuffer(out.frame);
        output.writePixels(static_cast<int>(image.height));
    } catch (const std::exception& e) {
        throw InputError(fmt::format("{}: cannot write OpenEXR: {}", path, e.what()));
    }
    save(stream, path);
}

void write_exr_parts(const std::vector<Image>& parts, const std::string& path, ExrPixel pixel) {
    std::vector<Outgoing> all(parts.size());
    std::vector<Imf::Header> headers;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        prepare(parts[k], path, pixel, all[k]);
        all[k].header.setType(Imf::SCANLINEIMAGE);
        all[k].header.displayWindow() = all[0].header.displayWindow(); // shared by all parts
        headers.push_back(all[k].header);
    }
    BytesOut stream(path);
    try {
        Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()),
                                        false, 0);
        for (std::size_t k = 0; k < parts.size(); ++k) {
            Imf::OutputPart part(output, static_cast<int>(k));
            part.setFrameBuffer(all[k].frame);
            part.writePixels(static_cast<int>(parts[k].height));
        }
    } catch (const std::exception& e) {
        throw InputError(fmt::format("{}: cannot write OpenEXR: {}", path, e.what()));
    }
    save(stream, path);
}

} // namespace brdfit
