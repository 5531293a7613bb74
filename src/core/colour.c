#include "core/colour.h"

#include <math.h>
#include <string.h>

const float gp_rec709_chromaticities[8] = {
    0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f,
};
const float gp_rec709_luminance[3] = {0.2126f, 0.7152f, 0.0722f};

int gp_rgb_to_xyz(const float ch[8], double m[9])
{
    // columns are the primaries' xyz; their scale S makes white's Y = 1
    double p[9], b[3], s[3];
    for (int i = 0; i < 8; i++) {
        if (!isfinite(ch[i]))
            return 0;
    }
    for (int i = 0; i < 3; i++) {
        p[i] = ch[2 * i];
        p[3 + i] = ch[2 * i + 1];
        p[6 + i] = 1.0 - (double) ch[2 * i] - (double) ch[2 * i + 1];
    }
    if (!(fabs((double) ch[7]) > 1e-6))
        return 0;
    b[0] = (double) ch[6] / (double) ch[7];
    b[1] = 1.0;
    b[2] = (1.0 - (double) ch[6] - (double) ch[7]) / (double) ch[7];
    // p * s = b by Cramer's rule
    const double c0 = p[4] * p[8] - p[5] * p[7];
    const double c1 = p[5] * p[6] - p[3] * p[8];
    const double c2 = p[3] * p[7] - p[4] * p[6];
    const double det = p[0] * c0 + p[1] * c1 + p[2] * c2;
    if (!(fabs(det) > 1e-12))
        return 0;
    s[0] = (b[0] * c0 + p[1] * (p[5] * b[2] - b[1] * p[8]) +
            p[2] * (b[1] * p[7] - p[4] * b[2])) / det;
    s[1] = (p[0] * (b[1] * p[8] - p[5] * b[2]) + b[0] * c1 +
            p[2] * (p[3] * b[2] - b[1] * p[6])) / det;
    s[2] = (p[0] * (p[4] * b[2] - b[1] * p[7]) +
            p[1] * (b[1] * p[6] - p[3] * b[2]) + b[0] * c2) / det;
    for (int i = 0; i < 9; i++)
        m[i] = p[i] * s[i % 3];
    return 1;
}

void gp_invert3(const double m[9], double out[9])
{
    double cofactor[9];
    for (int i = 0; i < 9; i++) {
        const int r1 = (i / 3 + 1) % 3 * 3, r2 = (i / 3 + 2) % 3 * 3;
        const int c1 = (i + 1) % 3, c2 = (i + 2) % 3;
        cofactor[i] = m[r1 + c1] * m[r2 + c2] - m[r1 + c2] * m[r2 + c1];
    }
    const double det =
        m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
    for (int i = 0; i < 9; i++)
        out[i] = cofactor[i % 3 * 3 + i / 3] / det;
}

void gp_luminance_weights(const float ch[8], float weight[3])
{
    double m[9];
    memcpy(weight, gp_rec709_luminance, sizeof gp_rec709_luminance);
    if (memcmp(ch, gp_rec709_chromaticities, sizeof gp_rec709_chromaticities) ==
            0 || !gp_rgb_to_xyz(ch, m))
        return;
    for (int c = 0; c < 3; c++)
        weight[c] = (float) m[3 + c];
}

float gp_srgb_encode(float linear)
{
    if (!(linear > 0.0f))
        return 0.0f;
    if (linear >= 1.0f)
        return 1.0f;
    return linear <= 0.0031308f ? 12.92f * linear
                                : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

float gp_srgb_decode(float encoded)
{
    if (!(encoded > 0.0f))
        return 0.0f;
    if (encoded >= 1.0f)
        return 1.0f;
    return encoded <= 0.04045f ? encoded / 12.92f
                               : powf((encoded + 0.055f) / 1.055f, 2.4f);
}
