// SPDX-License-Identifier: Apache-2.0
// OpenColorIO for C: the functions of tone/ocio_bridge.h.
#include "tone/ocio_bridge.h"

#include "core/status.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <strings.h>
#include <sys/stat.h>

namespace OCIO = OCIO_NAMESPACE;

namespace {

using Names = std::vector<std::string>;

// An error line, its status and the parameter that it is about.
struct Refusal {
    int status;
    const char *parameter;
    std::string line;
};

// Kept as long as the processors.
struct Owned {
    OCIO::ConstCPUProcessorRcPtr view, output;
    std::string config, input, display, viewed, look, wanted;
    std::vector<std::string> files;
    std::vector<const char *> file; // of these
};

// A config and what it was asked for.
struct Asked {
    const glarepp_tone_params *p;
    OCIO::ConstConfigRcPtr config;
    OCIO::ConstContextRcPtr context;
    Owned *own;
};

// OpenColorIO writes paragraphs, with a dot at their end.
std::string one_line(const std::string &text)
{
    std::string line;
    for (const char c : text) {
        const bool space = static_cast<unsigned char>(c) <= ' ';
        if (!space)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && (line.back() == ' ' || line.back() == '.'))
        line.pop_back();
    const std::size_t most = 400;
    return line.size() > most ? line.substr(0, most) + "..." : line;
}

// "A, B, C and 12 more"
std::string list_names(const Names &names)
{
    const std::size_t most = 400;
    std::string line;
    std::size_t i = 0;
    for (; i < names.size() && (i == 0 || line.size() < most); i++)
        line += (i ? ", " : "") + one_line(names[i]);
    if (i < names.size())
        line += " and " + std::to_string(names.size() - i) + " more";
    return line;
}

[[noreturn]] void refuse_name(const char *parameter, const Asked &a,
                              const std::string &what,
                              const std::string &found, const Names &names)
{
    const std::string line = a.own->config + ": has no such " + what +
                             " (found \"" + found + "\"";
    throw Refusal{GP_ERR_USAGE, parameter,
                  line + (names.empty()
                              ? ", it has none)"
                              : "); give one of " + list_names(names))};
}

// -- the config --------------------------------------------------------------

OCIO::ConstConfigRcPtr read_config(const std::string &name)
{
    const char *const file = "tone.config.file";
    const bool builtin = name.compare(0, 7, "ocio://") == 0;
    if (builtin && OCIO::GetVersionHex() < 0x02020000)
        throw Refusal{GP_ERR_USAGE, file,
                      name + ": OpenColorIO " + OCIO::GetVersion() +
                          " has no built-in configs (2.2 was the first); "
                          "give a config file"};
    // A YAML parser that is handed a device never ends; one of many megabytes
    // is no config, and takes many times its size. (Archives hold LUTs too.)
    const long long most = 16LL << 20;
    const bool archive = name.size() > 6 &&
                         name.compare(name.size() - 6, 6, ".ocioz") == 0;
    struct stat s;
    if (!builtin && stat(name.c_str(), &s) != 0)
        throw Refusal{GP_ERR_IO, file,
                      name + ": cannot read the OCIO config (" +
                          std::strerror(errno) + "); check the name"};
    if (!builtin && !S_ISREG(s.st_mode))
        throw Refusal{GP_ERR_IO, file,
                      name + ": an OCIO config is a file (found something "
                             "else); name config.ocio"};
    if (!builtin && s.st_size > most && !archive)
        throw Refusal{GP_ERR_DATA, file,
                      name + ": too large for an OCIO config (" +
                          std::to_string(s.st_size) +
                          " bytes); check the name"};
    try {
        return OCIO::Config::CreateFromFile(name.c_str());
    } catch (const OCIO::Exception &e) {
        // without the file's name, which the line has already
        const std::string head =
            "Error: Loading the OCIO profile '" + name + "' failed. ";
        std::string why = e.what();
        if (why.compare(0, head.size(), head) == 0)
            why.erase(0, head.size());
        if (why == std::bad_alloc().what()) // of what it has caught
            throw Refusal{GP_ERR_BUG, "",
                          name + ": out of memory; close other programs"};
        throw Refusal{GP_ERR_DATA, file,
                      name + ": OpenColorIO " + OCIO::GetVersion() +
                          " refuses it (" + one_line(why) +
                          "); use a config that it can read"};
    }
}

// -- names -------------------------------------------------------------------

Names all(int n, const std::function<const char *(int)> &name)
{
    Names names;
    for (int i = 0; i < n; i++)
        names.push_back(name(i));
    return names;
}

// As the config spells it; roles, aliases and inactive ones count.
std::string find_space(const Asked &a, const char *parameter, const char *name)
{
    const OCIO::ConstColorSpaceRcPtr space = a.config->getColorSpace(name);
    if (space)
        return space->getName();
    const OCIO::ConstConfigRcPtr &c = a.config;
    Names names = all(c->getNumColorSpaces(), [&](int i) {
        return c->getColorSpaceNameByIndex(i);
    });
    for (int i = 0; i < c->getNumRoles(); i++)
        names.push_back(std::string(c->getRoleName(i)) + " (role)");
    refuse_name(parameter, a, "colour space", name, names);
}

std::string find_view(const Asked &a, const std::string &display)
{
    const OCIO::ConstConfigRcPtr &c = a.config;
    const char *const d = display.c_str();
    if (!a.p->view) { // the rules of views may have none for this space
        const std::string name = c->getDefaultView(d, a.own->input.c_str());
        return name.empty() ? c->getDefaultView(d) : name;
    }
    for (const OCIO::ViewType type :
         {OCIO::VIEW_DISPLAY_DEFINED, OCIO::VIEW_SHARED}) {
        for (int i = 0; i < c->getNumViews(type, d); i++) {
            std::string name = c->getView(type, d, i);
            if (strcasecmp(name.c_str(), a.p->view) == 0)
                return name;
        }
    }
    refuse_name("tone.view", a, "view of display " + display, a.p->view,
                all(c->getNumViews(d), [&](int i) {
                    return c->getView(d, i);
                }));
}

// -- processors --------------------------------------------------------------

[[noreturn]] void refuse_transform(const Asked &a, const std::string &what,
                                   const std::exception &e)
{
    throw Refusal{GP_ERR_DATA, "tone.context",
                  a.own->config + ": OpenColorIO " + OCIO::GetVersion() +
                      " cannot make " + what + " (" + one_line(e.what()) +
                      "); check the config and its files"};
}

OCIO::ConstCPUProcessorRcPtr keep(Owned *own,
                                  const OCIO::ConstProcessorRcPtr &p)
{
    const auto known = p->getProcessorMetadata();
    for (int i = 0; i < known->getNumFiles(); i++)
        own->files.emplace_back(known->getFile(i));
    return p->getDefaultCPUProcessor();
}

void make_view(const Asked &a)
{
    Owned *const own = a.own;
    const OCIO::ConstConfigRcPtr &c = a.config;
    const std::string display =
        a.p->display ? a.p->display : c->getDefaultDisplay();
    // those that the config has made inactive may be asked for
    for (int i = 0; i < c->getNumDisplaysAll() && own->display.empty(); i++) {
        if (strcasecmp(c->getDisplayAll(i), display.c_str()) == 0)
            own->display = c->getDisplayAll(i);
    }
    if (own->display.empty())
        refuse_name("tone.display", a, "display", display,
                    all(c->getNumDisplays(), [&](int i) {
                        return c->getDisplay(i);
                    }));
    own->viewed = find_view(a, own->display);
    own->look = a.p->look ? a.p->look : "";
    // looks are separated by , : and |, with + or - before them
    for (std::size_t at = 0, end; at < own->look.size(); at = end + 1) {
        end = std::min(own->look.find_first_of(",:|", at), own->look.size());
        const std::size_t first = own->look.find_first_not_of(" +-", at);
        if (first >= end)
            continue;
        std::string name = own->look.substr(first, end - first);
        name.erase(name.find_last_not_of(' ') + 1);
        if (!a.config->getLook(name.c_str()))
            refuse_name("tone.look", a, "look", name,
                        all(a.config->getNumLooks(), [&](int i) {
                            return a.config->getLookNameByIndex(i);
                        }));
    }
    try {
        const auto view = OCIO::DisplayViewTransform::Create();
        view->setSrc(own->input.c_str());
        view->setDisplay(own->display.c_str());
        view->setView(own->viewed.c_str());
        const auto pipeline = OCIO::LegacyViewingPipeline::Create();
        pipeline->setDisplayViewTransform(view);
        if (a.p->look) {
            pipeline->setLooksOverride(a.p->look);
            pipeline->setLooksOverrideEnabled(true);
        }
        own->view = keep(own, pipeline->getProcessor(a.config, a.context));
    } catch (const OCIO::Exception &e) {
        refuse_transform(a, "view " + own->viewed + " of display " +
                                own->display, e);
    }
}

// -- colours of a space ------------------------------------------------------

using Pixel = std::array<float, 3>;

// The transform as a function; empty where the config has none.
std::function<Pixel(Pixel)> transform_of(const Asked &a, const char *from,
                                         const char *to)
try {
    const auto p = a.config->getProcessor(a.context, from, to)
                       ->getDefaultCPUProcessor();
    return [p](Pixel v) {
        p->applyRGB(v.data());
        return v;
    };
} catch (const OCIO::Exception &) {
    return {};
}

bool is_near(double x, double y, double scale)
{
    return std::fabs(x - y) <= 1e-4 * scale; // false for NaN
}

// The light of a space by a space that is known: what the config says it is,
// or what widespread configs call so.
gp_ocio_light light_of(const Asked &a, const std::string &space)
{
    static const float ap0[8] = {0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f,
                                 0.32168f, 0.33767f};
    static const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f,
                                 0.32168f, 0.33767f};
    static const float bt709[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f,
                                   0.3127f, 0.329f};
    static const struct {
        const char *name;
        const float *of;
    } known[] = {
        {"aces_interchange", ap0}, {"ACES2065-1", ap0}, {"lin_ap0", ap0},
        {"ACES - ACES2065-1", ap0}, {"ACEScg", ap1}, {"lin_ap1", ap1},
        {"ACES - ACEScg", ap1}, {"lin_rec709", bt709},
        {"Linear Rec.709 (sRGB)", bt709}, {"Linear Rec.709", bt709},
        {"Utility - Linear - sRGB", bt709},
    };
    static const Pixel probes[] = {
        {0, 0, 0}, {4, 8, 2}, {0.01f, 0.02f, 0.005f}};
    gp_ocio_light light = {};
    for (const auto &k : known) {
        const auto reference = a.config->getColorSpace(k.name);
        if (!reference || reference->isData() ||
            a.config->getColorSpace(space.c_str())->isData())
            continue;
        const auto f = transform_of(a, space.c_str(), reference->getName());
        if (!f)
            continue;
        for (int c = 0; c < 3; c++) {
            Pixel unit = {};
            unit[c] = 0.25f;
            const Pixel got = f(unit);
            for (int i = 0; i < 3; i++)
                light.matrix[3 * i + c] = 4.0 * got[i];
        }
        light.known = true; // when it is linear
        for (const Pixel &in : probes) {
            const Pixel got = f(in);
            for (int i = 0; i < 3; i++) {
                const double *const row = light.matrix + 3 * i;
                light.known = light.known &&
                              is_near(got[i], row[0] * in[0] + row[1] * in[1] +
                                                  row[2] * in[2],
                                      in[1] > 0 ? in[1] : 1e-3);
            }
        }
        std::copy(k.of, k.of + 8, light.of);
        return light;
    }
    return {};
}

// x and y of a colour in CIE XYZ are within 0.002 of these.
bool is_at(const Pixel &xyz, double x, double y)
{
    const double sum = static_cast<double>(xyz[0]) + xyz[1] + xyz[2];
    return sum > 0 && std::fabs(xyz[0] / sum - x) < 0.002 &&
           std::fabs(xyz[1] / sum - y) < 0.002;
}

// The code points of the view's display space: by its light at some codes where
// the config knows CIE XYZ, else by what configs without it call PQ and HLG.
void find_code_points(const Asked &a, unsigned char cicp[2])
{
    enum { BT709 = 1, BT2020 = 9, P3_D65 = 12, SRGB = 13, PQ = 16, HLG = 18 };
    static const struct {
        int code;
        double half, most; // light at codes 0.5 and 0.75, of that at 1
    } curves[] = {
        {SRGB, 0.21404, 0.52252},
        {PQ, 0.0092246, 0.098329}, // SMPTE ST 2084
        {HLG, 0.050704, 0.20315},  // ITU-R BT.2100, with its OOTF of 1.2
    };
    static const struct {
        int code;
        double xy[3][2];
    } gamuts[] = {
        {BT709, {{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}}},
        {P3_D65, {{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}}},
        {BT2020, {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}}},
    };
    const OCIO::ConstConfigRcPtr &c = a.config;
    const char *name = c->getDisplayViewColorSpaceName(
        a.own->display.c_str(), a.own->viewed.c_str());
    if (!name || !*name ||
        std::strcmp(name, OCIO::OCIO_VIEW_USE_DISPLAY_NAME) == 0)
        name = a.own->display.c_str();
    const auto space = c->getColorSpace(name);
    auto xyz = c->getColorSpace("cie_xyz_d65_interchange");
    if (!xyz)
        xyz = c->getColorSpace("CIE-XYZ-D65");
    std::function<Pixel(Pixel)> light;
    if (space && xyz && !space->isData() &&
        space->getReferenceSpaceType() == OCIO::REFERENCE_SPACE_DISPLAY)
        light = transform_of(a, space->getName(), xyz->getName());
    if (light) {
        const double one = light({1, 1, 1})[1];
        const double half = light({0.5f, 0.5f, 0.5f})[1] / one;
        const double most = light({0.75f, 0.75f, 0.75f})[1] / one;
        const Pixel rgb[] = {light({1, 0, 0}), light({0, 1, 0}),
                             light({0, 0, 1})};
        for (const auto &k : curves) {
            if (std::fabs(half / k.half - 1) < 5e-3 &&
                std::fabs(most / k.most - 1) < 5e-3)
                cicp[1] = static_cast<unsigned char>(k.code);
        }
        for (const auto &g : gamuts) {
            if (is_at(rgb[0], g.xy[0][0], g.xy[0][1]) &&
                is_at(rgb[1], g.xy[1][0], g.xy[1][1]) &&
                is_at(rgb[2], g.xy[2][0], g.xy[2][1]))
                cicp[0] = static_cast<unsigned char>(g.code);
        }
    } else if (!space || !space->isData()) {
        const auto has = [name](const char *word) {
            return strcasestr(name, word) != nullptr;
        };
        const bool wide = has("2020") || has("2100");
        cicp[1] = has("HLG") ? HLG : has("PQ") || has("2084") ? PQ : 0;
        cicp[0] = wide || has("HLG") ? BT2020 : has("P3") ? P3_D65 : 0;
    }
    if (!cicp[0] || !cicp[1])
        cicp[0] = cicp[1] = 0;
}

const char *text_or_null(const std::string &s)
{
    return s.empty() ? nullptr : s.c_str();
}

int put(const Refusal &r, gp_ocio_fault *fault)
{
    const std::string text = r.line.substr(0, sizeof fault->line - 1);
    std::memcpy(fault->line, text.c_str(), text.size() + 1);
    std::strcpy(fault->parameter, r.parameter);
    return r.status;
}

int open_config(const glarepp_tone_params *p, gp_ocio_opened *out,
                gp_ocio_fault *fault)
try {
    *out = {};
    auto own = std::make_unique<Owned>();
    // errors come as exceptions; nobody asked for the rest on stderr
    OCIO::SetLoggingFunction([](const char *) {});
    own->config = p->config;
    Asked a{p, read_config(own->config), nullptr, own.get()};
    const OCIO::ContextRcPtr context =
        a.config->getCurrentContext()->createEditableCopy();
    for (int i = 0; i < p->contexts; i++) {
        const std::string text = p->context[i];
        const std::size_t is = text.find('=');
        if (is == 0 || is == std::string::npos)
            throw Refusal{GP_ERR_USAGE, "tone.context",
                          "OpenColorIO: no setting of a context (found \"" +
                              text + "\")"};
        context->setStringVar(text.substr(0, is).c_str(),
                              text.substr(is + 1).c_str());
    }
    a.context = context;
    const char *space = p->input;
    for (const char *const role : {"scene_linear", "reference", "default"}) {
        if (!space && a.config->hasRole(role))
            space = role;
    }
    own->input = find_space(a, "tone.input",
                            space ? space : "scene_linear"); // lists all
    if (p->shows) {
        make_view(a);
        find_code_points(a, out->facts.cicp);
    }
    if (!p->any_primaries || p->output)
        out->input_light = light_of(a, own->input);
    if (p->output) {
        own->wanted = find_space(a, "tone.output", p->output);
        try {
            own->output = keep(own.get(), a.config->getProcessor(
                a.context, own->input.c_str(), own->wanted.c_str()));
        } catch (const OCIO::Exception &e) {
            refuse_transform(a, own->wanted + " from " + own->input, e);
        }
        out->output_light = light_of(a, own->wanted);
    }
    out->facts.config = own->config.c_str();
    out->facts.input = own->input.c_str();
    out->facts.display = text_or_null(own->display);
    out->facts.view = text_or_null(own->viewed);
    out->facts.look = text_or_null(own->look);
    out->facts.output = text_or_null(own->wanted);
    for (const std::string &name : own->files)
        own->file.push_back(name.c_str());
    out->facts.file = own->file.data();
    out->facts.files = static_cast<int>(own->file.size());
    out->view = own->view.get();
    out->output = own->output.get();
    out->own = own.release();
    return GP_OK;
} catch (const Refusal &r) {
    return put(r, fault);
} catch (const std::exception &e) {
    return put({GP_ERR_BUG, "tone.config", "OpenColorIO: failed (" +
                one_line(e.what()) + ")"}, fault);
} catch (...) {
    return put({GP_ERR_BUG, "tone.config", "OpenColorIO: failed"}, fault);
}

void close_config(gp_ocio_opened *opened)
{
    delete static_cast<Owned *>(opened->own);
    *opened = {};
}

int apply(const void *processor, float *r, float *g, float *b, std::size_t n)
try {
    OCIO::PlanarImageDesc pixels(r, g, b, nullptr, static_cast<long>(n), 1);
    static_cast<const OCIO::CPUProcessor *>(processor)->apply(pixels);
    return 0;
} catch (...) {
    return -1;
}

const struct gp_ocio_api api = {GP_OCIO_API_VERSION, open_config, close_config,
                                apply};

} // namespace

extern "C" __attribute__((visibility("default"))) const struct gp_ocio_api *
gp_ocio_api(void)
{
    return &api;
}
