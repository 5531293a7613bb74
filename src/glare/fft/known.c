// SPDX-License-Identifier: Apache-2.0
/* Plans of the lengths that fft takes most, measured by
 *
 *     make known-plans
 *
 * as FFTW's wisdom: a length's solvers, each with the hash of what it solves.
 * FFTW of another version, or on a CPU with other vector instructions, refuses
 * them, and estimates its plans. */
#include "glare/fft/fft_priv.h"

#define HEAD                                                                  \
    "(fftw-3.3.10 fftwf_wisdom #x9e7d4dee #xdb14fed1 #x34bf76a4 #xeb6e8fdf"
#define S(name, index, a, b, c, d)                                            \
    "(fftwf_" name " " #index " #x11bdd #x11bdd #x0 #x" #a " #x" #b          \
    " #x" #c " #x" #d ")"

static const struct {
    int n;
    const char *wisdom;
} known[] = {
    {512, HEAD
     S("codelet_t2fv_64_avx", 0, feec02f8, bbf06357, b26e7a2b, f7b9dcb8)
     S("codelet_n2fv_8_avx", 0, 3f177dac, d6bae8fd, ec314547, 95908075)
     S("codelet_t2bv_64_avx", 0, 71b35416, 033191ee, 08427f48, 060813e0)
     S("codelet_n2bv_8_avx", 0, 3c3f5102, a27b92c3, 235c75ee, 2fe6d6a2)
     ")"},
    {576, HEAD
     S("dft_vrank_geq1_register", 0, 23c1005d, d2c01d1f, 5076acba, 7d5768ad)
     S("codelet_t1fv_12_avx", 0, 56e18ae4, b1afc674, 0ae98788, f1c821eb)
     S("codelet_n1fv_12_avx", 0, 292e1dcf, aa353073, cf0734c0, 3eb89b1a)
     S("codelet_t2fv_4_avx", 0, 416be6c5, d9224b58, 2dcc4e71, 0ac5ebc0)
     S("codelet_t2bv_4_avx", 0, f7bee392, c825c4fc, aee66672, 34ebb623)
     S("codelet_n1bv_12_avx", 0, 02363219, aae5c3fa, fe3bbe8b, 9dfbbee0)
     S("codelet_t1bv_12_avx", 0, 10cb3f38, 1818062b, 4b72e61e, 37e6d0d6)
     S("dft_vrank_geq1_register", 0, 8d00a393, ec6329f2, efbce503, 5eb8c12f)
     ")"},
    {640, HEAD
     S("codelet_n2fv_20_avx", 0, 57bdb844, c3bad151, c57e7224, a06d5f8f)
     S("codelet_t2fv_32_avx", 0, 3dce61cd, 734c6dee, 2dc5352a, 8304534b)
     S("codelet_t2bv_20_avx", 0, d0940e0e, c72734f1, ef0bbd22, 620052fc)
     S("codelet_n2bv_32_avx", 0, 943bb2a9, 09c42a5d, 122589ba, fab7ee77)
     ")"},
    {672, HEAD
     S("dft_vrank_geq1_register", 0, a75c49ce, 34464256, b6586c1e, 0fa94b01)
     S("codelet_n1fv_14_avx", 0, cccd7d7c, 2a341adf, c6b8f3e2, 7f7f18a4)
     S("codelet_t2fv_8_sse2", 0, 791d77c7, 5b99a2cc, 033cfa30, a19a709c)
     S("codelet_t1fv_6_avx", 0, 34f1ab37, 97f5bfa2, 48364c73, 0929be3c)
     S("codelet_n1bv_12_avx", 0, 96c7e381, ecdea79e, d617cbc1, f7dec142)
     S("dft_vrank_geq1_register", 0, 79103ab0, a668b960, ddda7f55, b0e4cf7f)
     S("codelet_t1bv_7_avx", 0, 566abee0, 14651ce1, b5b39f21, 2e48e33a)
     S("codelet_t2bv_8_avx", 0, a696cc44, 630dd0ff, 2d19c71d, c3accde2)
     ")"},
    {768, HEAD
     S("codelet_n2fv_12_avx", 0, ecd9d866, 37ea6295, 48c8aebe, 0b85c7fe)
     S("codelet_t2fv_64_avx", 0, 3cc9797d, 91d96cce, 23d08481, 0d4d65b2)
     S("codelet_n2bv_12_avx", 0, b3f3e01d, 274c1b2e, ec22e7dd, 3833d655)
     S("codelet_t2bv_64_avx", 0, 8e69159f, dbba7098, a44079db, 55214eca)
     ")"},
    {800, HEAD
     S("codelet_t2fv_20_avx", 0, a4ed6058, 58465541, 0880ae41, 9a016c0b)
     S("codelet_n1fv_20_avx", 0, 962dfd53, 7e397b2a, c1f17843, 1c800ed6)
     S("dft_vrank_geq1_register", 0, 79c9607d, a97b231a, ad63331e, 8eed616b)
     S("codelet_t1fv_2_avx", 0, 921ce1e0, 964a9c00, a1abd18b, c3ba7982)
     S("codelet_t2bv_20_avx", 0, a1716d9e, eec983b2, b3f84f49, ceb92f1d)
     S("dft_vrank_geq1_register", 0, ea3d5f02, 826aa0e7, cdc2f38f, a961edc4)
     S("codelet_t1bv_5_avx", 0, 9f3a1f85, 76e426a4, 78dee2ec, a49957a3)
     S("codelet_n1bv_8_avx", 0, 97173a0c, 2984346c, f0323348, dce74a42)
     ")"},
    {896, HEAD
     S("codelet_t1fv_7_avx", 0, 87709d09, 2d20c612, 720192b5, 57af0c7f)
     S("dft_vrank_geq1_register", 0, 8bd29f14, 67fb8333, 0479e2c3, 0ac4767d)
     S("codelet_n1fv_8_avx", 0, b5604778, 209f9e02, b6d6c9ff, e8842e50)
     S("codelet_t2fv_16_avx", 0, 66567819, c850b794, dd21c6c2, 372317b3)
     S("dft_vrank_geq1_register", 0, 87ef55fc, 7499c535, fd5b22a7, 6179171e)
     S("codelet_t1bv_7_avx", 0, b589d050, a7cc4790, 1d934894, 59d6bd05)
     S("codelet_n1bv_8_avx", 0, 0a3a8fa7, b336ee99, b0b134b3, c6961c2d)
     S("codelet_t2bv_16_avx", 0, ef8902ff, 04a1a034, 6d68c4ad, b4b76a51)
     ")"},
    {960, HEAD
     S("codelet_n1fv_12_avx", 0, 6c958ff5, ae0b2649, d9f60fd3, a6a072f1)
     S("dft_vrank_geq1_register", 0, e819fb58, 7f9806a4, 2555fbad, e537e564)
     S("codelet_t3fv_10_avx", 0, 8e67299c, 7a7f2659, 70764918, d1a71aec)
     S("codelet_t2fv_8_avx", 0, 3be6faeb, 299c85f9, ff67f7a4, 6a3f2c75)
     S("codelet_t1bv_6_avx", 0, 40f737ed, 7bfc3404, 4ae8b548, 8dce3cd2)
     S("codelet_n1bv_8_avx", 0, 61a64725, e40d114b, 21811449, 9c16ebc1)
     S("codelet_t2bv_20_avx", 0, 9fa6be30, d4c16be8, 90b42aa0, debb2fc7)
     S("dft_vrank_geq1_register", 0, b92a35a4, ec1e7890, 3ab5c509, 6a47e129)
     ")"},
    {1024, HEAD
     S("codelet_t1fv_32_avx", 0, c6ca45ce, f08c5f4a, 61a53ade, e5e374c8)
     S("codelet_n2fv_32_avx", 0, 407181dc, 8a77cb1e, a88df8c5, a32373b5)
     S("codelet_t2bv_32_avx", 0, d86f0fcc, 804581bb, 5ccfdfba, 14108c49)
     S("codelet_n2bv_32_avx", 0, 9eb2edbf, 922114ae, b3ba36b9, 31dd942c)
     ")"},
    {1152, HEAD
     S("codelet_t1fv_16_avx", 0, cc391dfa, 7d465209, b206c237, 0382ed34)
     S("codelet_n1fv_12_avx", 0, 32eba8c6, f2d89972, 42a1d25c, 1fcfec70)
     S("dft_vrank_geq1_register", 0, cb199891, 68898199, 0627fbf2, ee0dc5d7)
     S("codelet_t1fv_6_avx", 0, 5e232948, cc2a741f, 975a6b38, 3cb1d973)
     S("codelet_t1bv_12_avx", 0, fd5c273d, 34c5dd95, a95b9e80, 7a0ced3f)
     S("codelet_n1bv_12_avx", 0, 23b38887, 72872498, 6285bcbc, 3bcbd071)
     S("dft_vrank_geq1_register", 0, fc8a302c, 61bbfa5a, ca86c550, 7446e600)
     S("codelet_t2bv_8_avx", 0, 18dcd02f, 6605fa60, 375c0820, 541879d6)
     ")"},
    {1280, HEAD
     S("codelet_t2fv_20_avx", 0, aed69cea, e0da4853, eb2ee804, 7dcf907c)
     S("codelet_n2fv_64_avx", 0, 5fc900e0, a70664fb, e9d21e06, 376faa9e)
     S("codelet_t2bv_20_avx", 0, ddc24bd5, 7fefbaf7, 9857c7e5, 3c336f95)
     S("codelet_n2bv_64_avx", 0, 574af47f, ba902c5c, a31075d1, 239fd2eb)
     ")"},
    {1344, HEAD
     S("codelet_t1fv_7_avx", 0, 5e11050d, b064d3ca, 90176252, ad1063c0)
     S("dft_vrank_geq1_register", 0, 88de9793, ce5e4764, df898b52, b1a6b1b7)
     S("codelet_t2fv_16_avx", 0, 3dd79c2f, 7c39b7d6, f871ac00, 8110e009)
     S("codelet_n1fv_12_avx", 0, 8ab15892, 8035e0a8, 1d3793ab, 578075f4)
     S("codelet_t1bv_7_avx", 0, 9b556a7d, 8d25608d, 19228e6b, 9bf1d612)
     S("codelet_t1bv_16_avx", 0, 377ff9d9, a631b997, 991671ea, 41d2efe2)
     S("codelet_n1bv_12_sse2", 0, e9510b26, 64c1c8ff, a94aed9b, b00c0898)
     S("dft_vrank_geq1_register", 0, c71ac187, b2342416, 2150c76f, 123fc256)
     ")"},
    {1536, HEAD
     S("codelet_t1fv_12_avx", 0, 5f2761de, 09897664, 94ae9912, ac989cc9)
     S("codelet_n1fv_128_avx", 0, bf4c69be, 4f426bf3, 1527cac6, 19edb8c4)
     S("dft_vrank_geq1_register", 0, 6563fc36, ac6dc12f, a132a550, a84eff6d)
     S("codelet_n1bv_12_avx", 0, 826d886f, 53eb1304, 09dff8b2, 64c57f25)
     S("codelet_t1bv_2_avx", 0, 93900f75, c743c003, 9ab5abf5, 6552184a)
     S("codelet_t1bv_64_avx", 0, 1717d03e, 41d7755d, 308ebc66, cb657c46)
     ")"},
    {1600, HEAD
     S("dft_vrank_geq1_register", 0, 61734034, 06cff4cd, 5047a9be, 1808d5a8)
     S("codelet_t2fv_4_avx", 0, db187bc3, 3b44e476, beb5898a, 01c14028)
     S("codelet_t2fv_20_avx", 0, 6e18887b, 52d9a462, 0d049bcc, 30c980a3)
     S("codelet_n1fv_20_avx", 0, 53409b65, 50b7daac, 339ac323, c3506718)
     S("dft_vrank_geq1_register", 0, 5696f21a, ef3cbbb8, 3b2d5cf0, 520ca16a)
     S("codelet_t2bv_4_avx", 0, 7fe8a900, 3510d46f, 082cccf8, 2c8a2818)
     S("codelet_n1bv_20_avx", 0, 58c37888, 08bcce87, 20c0d08d, 6c150194)
     S("codelet_t2bv_20_avx", 0, cc971dbe, 15bcdfed, fac53568, 91278f38)
     ")"},
    {1792, HEAD
     S("dft_vrank_geq1_register", 0, f46bee18, 3142b498, 268a0d24, 2734e9e3)
     S("codelet_t2fv_16_avx", 0, 05663525, ce1443b1, 974398f2, 784659a8)
     S("dft_vrank_geq1_register", 0, 797c138a, 51744b7e, cdfb7950, d6b8bc3f)
     S("codelet_n1fv_8_avx", 0, 72157fff, 031b89fa, e2f3865a, 64564907)
     S("codelet_t1fv_2_avx", 0, 9f812532, 35d8fb79, 2c0796bc, 793c2765)
     S("codelet_t1fv_7_avx", 0, 02e5cb9f, 07badb9a, b3e9136e, 1c552ddf)
     S("codelet_t2bv_8_sse2", 0, b6494795, a1e9673f, 3dec86c9, 4071d5ed)
     S("codelet_t2bv_16_avx", 0, 693fbd16, d5270668, eacbc7ea, 80f46e36)
     S("dft_vrank_geq1_register", 0, 830cc328, 9e64cfe4, fe1d1b53, 8a42fb2d)
     S("codelet_n1bv_14_avx", 0, 302595cd, f7e0f2e9, 647f5f03, aa9c9da3)
     ")"},
    {1920, HEAD
     S("codelet_n1fv_12_avx", 0, 8872ebf5, 61f5f66b, 2b7f2592, f1b2dc3d)
     S("codelet_t2fv_20_avx", 0, f210e126, 203f2560, 683a4861, 725827f1)
     S("dft_vrank_geq1_register", 0, 8ef57512, c9785fbd, cc1581bc, ac326415)
     S("codelet_t2fv_8_avx", 0, 3bcae30f, 7d02bc18, 1cc7910c, 47b861b7)
     S("codelet_t2bv_32_avx", 0, 345c8a7c, d43c492d, 982de966, 4ea0f116)
     S("dft_vrank_geq1_register", 0, 6bc5db6c, 46492736, 6d46ca53, fb011b77)
     S("codelet_t2bv_5_avx", 0, ebc79465, f53d02f9, 3549fae3, 66fd3ba3)
     S("codelet_n1bv_12_avx", 0, 8e80aa8b, 861efeef, 84f48f95, b021c9a1)
     ")"},
    {2048, HEAD
     S("codelet_t1fv_64_avx", 0, a5af12be, 8ea95383, cd10c847, e6812dfa)
     S("codelet_n2fv_32_avx", 0, 8a4c5fa4, b54017ef, 048c03df, 4f290280)
     S("codelet_t1bv_32_avx", 0, 889f271b, fc322bc3, 77dab9f2, 358ba725)
     S("codelet_n2bv_64_avx", 0, 6c447a57, 88d0c094, 74220cbd, a4af46b7)
     ")"},
    {2304, HEAD
     S("codelet_t2fv_16_avx", 0, cce36283, 4d140b3c, 1b0cd0b9, 5aee7798)
     S("codelet_t1fv_12_avx", 0, 09d2067e, e82dea8f, 98ae3544, 372f7834)
     S("codelet_n1fv_12_avx", 0, 3df4abd1, a2aaa1a1, d8ae5fb4, 251fcaf1)
     S("dft_vrank_geq1_register", 0, 2e820134, afe0b76f, 3320915e, b23ad24e)
     S("codelet_t1bv_3_avx", 0, 2082fc47, 629b6490, 93635889, 2c809cc3)
     S("dft_vrank_geq1_register", 0, 23c422d3, e2dcb8d8, bc139396, bd43cd5c)
     S("codelet_t2bv_64_avx", 0, 81fce4cc, 5cb0393e, e5622aa5, 5fd86fb9)
     S("codelet_n1bv_12_sse2", 0, 14605f85, af577447, 68e331df, 4278cd6d)
     ")"},
    {2560, HEAD
     S("codelet_t2fv_20_avx", 0, badfdc2b, 7cce05b8, 9833b023, 4f830354)
     S("codelet_n1fv_128_avx", 0, 0135511f, 6f779959, 24b59425, 4e445b74)
     S("codelet_n1bv_64_avx", 0, 56782ee9, 0aa40c2e, 235ca1ae, 3a249d22)
     S("codelet_t2bv_2_avx", 0, e1c8ca69, f3da60c6, 52fc7e1a, 86111242)
     S("dft_vrank_geq1_register", 0, bb70ecfd, fe98261f, 092981af, e7b23935)
     S("codelet_t2bv_20_avx", 0, fba72ff3, 58a859d5, bdc87d26, f27496bd)
     ")"},
    {2688, HEAD
     S("dft_vrank_geq1_register", 0, 9284796f, 59471481, 14206719, 66a8772a)
     S("codelet_t1fv_12_avx", 0, 23c26fba, b4456f9f, 8e43a8ac, 5192bc28)
     S("codelet_t1fv_7_avx", 0, dd0e964c, f819944e, 84039325, ebc1967d)
     S("codelet_n1fv_32_avx", 0, e86c9bf1, e55e6dba, 7bea1d3f, e3189061)
     S("codelet_t1bv_2_avx", 0, 2b8f05a4, e462f600, 17fa7370, 2e7e76a3)
     S("dft_vrank_geq1_register", 0, ae498305, b7cf4d68, 8e7c2bae, fbbed28c)
     S("codelet_t1bv_7_avx", 0, 57c0cf44, 111aaf5e, 0e4ef6ea, b804664d)
     S("dft_vrank_geq1_register", 0, 9f000b1f, a4aedc96, b0661528, f5edd921)
     S("codelet_t1bv_16_avx", 0, 61e0b395, ace69067, 6c4fa349, 40750a5d)
     S("codelet_n1bv_12_avx", 0, 6387ea42, 996949ae, de4fca08, 23dfbb8c)
     ")"},
    {3072, HEAD
     S("codelet_t1fv_16_avx", 0, eb0dc7c1, b5ea54e1, 00f3f289, 9173b7ad)
     S("codelet_t1fv_3_avx", 0, 0c3d0059, b89898ae, e6b3568a, c86cda94)
     S("dft_vrank_geq1_register", 0, ca952207, a5f57d68, 62a726a1, ccc0a8a2)
     S("codelet_n1fv_64_avx", 0, b0306855, 7d46e893, 96bcaa56, b20a470d)
     S("codelet_n1bv_128_avx", 0, c5f4760c, ec86f43b, c5935c1f, 4d28fefe)
     S("dft_vrank_geq1_register", 0, 704188bd, b29c1b86, 56e5bb80, 929144c5)
     S("codelet_t1bv_12_avx", 0, 085c3910, c6f89bf1, f52f59d3, 7dff3982)
     S("codelet_t1bv_2_avx", 0, c47e42b0, a8ab65a3, 145ae5f2, 67aabf1e)
     ")"},
    {3200, HEAD
     S("codelet_t1fv_20_avx", 0, f5d07128, 369ef9c3, c3584110, 4d3f931b)
     S("codelet_n1fv_8_avx", 0, 013aad54, 447d7e70, aaca319d, 0e8de3fe)
     S("dft_vrank_geq1_register", 0, acd56192, d17a8cfe, d8e72517, d953f4f9)
     S("codelet_t2fv_20_avx", 0, 4dfd16c5, bc547bc6, fddd24a1, b8d739da)
     S("codelet_t2bv_20_avx", 0, 9b532b76, 3bde0fb4, 433c44cb, ced28a52)
     S("dft_vrank_geq1_register", 0, 94b7c5f8, 0ca97ec2, 396768b6, 5ab930bf)
     S("codelet_t1bv_20_avx", 0, 41ae04fa, 64eab238, b9b25335, 5628a224)
     S("codelet_n1bv_8_avx", 0, c9b0e19d, d57c075a, eebdba5e, bddb766d)
     ")"},
    {3584, HEAD
     S("codelet_t1fv_2_avx", 0, ed3d5d39, 1e362cb2, 6733c6d1, b6c39b60)
     S("codelet_t1fv_7_avx", 0, 8a612f14, 2129b40c, 54baad3e, 57249c37)
     S("codelet_t2fv_4_avx", 0, 0969f738, 2d39c7b8, 45d2ab68, 6a3a68f7)
     S("codelet_n1fv_64_avx", 0, 1a1d1ea8, 6dcd73c8, 265af989, 5aa66c22)
     S("dft_vrank_geq1_register", 0, 4463ee75, f4c63bf5, de3cf9a2, d491d412)
     S("dft_vrank_geq1_register", 0, e74eaeef, 085723a0, cf1ff9d8, 5af6976f)
     S("codelet_t2bv_32_avx", 0, 59cbc862, 3fd3f4e8, f5d0369b, 17fd3a8d)
     S("dft_vrank_geq1_register", 0, 907b2e4a, ceb826dc, 5510ecab, 4e8f2bd6)
     S("codelet_t1bv_2_avx", 0, 843da597, af06da59, 07f259d3, 03b5944c)
     S("dft_vrank_geq1_register", 0, bd132555, df997b0d, 27e046d2, ea5cd7b9)
     S("codelet_n1bv_8_avx", 0, 16264eea, 48c3179e, 68d07cbf, ca56e716)
     S("codelet_t1bv_7_avx", 0, 63f9b405, a9cb09d2, 6b34ac22, 6d1660c1)
     ")"},
    {3840, HEAD
     S("dft_vrank_geq1_register", 0, c4a1ea35, d8cf75c9, 131658a9, a6d315a7)
     S("codelet_n1fv_12_avx", 0, 231689e9, 65f731b0, f226b5b8, a029f832)
     S("codelet_t2fv_20_avx", 0, 8d4654a3, 51eca0dd, d6afbec3, 28fbe64d)
     S("codelet_t2fv_16_avx", 0, 6727d08b, bab0668a, faee53b2, d55fdafa)
     S("codelet_n1bv_12_avx", 0, 390931bf, 5ff164a2, a9202fe1, 4c4c52fd)
     S("codelet_t2bv_16_avx", 0, 64de686a, 0f2690b1, bd59f753, 7d7fdae5)
     S("dft_vrank_geq1_register", 0, 3bb48b0e, 0daad650, 0466f7c6, d254429e)
     S("codelet_t2bv_20_avx", 0, cecfa218, a694f799, e9019df8, 33ae6bf5)
     ")"},
    {4096, HEAD
     S("codelet_t1fv_64_avx", 0, 21c528b9, 63c201bc, a3c09b11, c2b338e6)
     S("codelet_n2fv_64_avx", 0, 27df1dad, 2c21af60, 212f0751, 93d6078b)
     S("codelet_n2bv_64_avx", 0, 173bfad6, fe0ac75c, 930d4dd6, 56064877)
     S("codelet_t2bv_64_avx", 0, b9da9e1a, b5ad84a3, d98a6c23, 906c1255)
     ")"},
    {4608, HEAD
     S("codelet_t2fv_64_avx", 0, 5a496ba5, c4b6ec81, 5a0270c9, 6b0b99c6)
     S("dft_vrank_geq1_register", 0, 67464cb2, ca88f39a, 55ba1375, 4e8e047b)
     S("codelet_t1fv_6_avx", 0, 60c0edd1, 95c8a5aa, fbc1d3e5, adf16411)
     S("codelet_n1fv_12_avx", 0, 208bf2c4, 821d2584, ed2691d1, d2c386cf)
     S("codelet_t1bv_6_avx", 0, ae1f4e2c, 37047027, 74beaf01, 86aad9c6)
     S("codelet_t1bv_64_avx", 0, 896ff783, ed3e359c, 1da00bf1, 3edc8833)
     S("dft_vrank_geq1_register", 0, 16b60c51, a9b32075, 6730fd4b, 15bc6bc4)
     S("codelet_n1bv_12_sse2", 0, 1a4bd05c, 7e13bfd6, 6e2cddd5, ca173f36)
     ")"},
    {5120, HEAD
     S("codelet_n1fv_128_avx", 0, 4f6be753, 57a406f5, 2afbcb28, 8edb823e)
     S("codelet_t1fv_2_avx", 0, 0217f82e, 8a79d4fc, 0ba8bb0b, 2d7f4328)
     S("codelet_t2fv_20_avx", 0, 6c31cf6d, cf9ec6c4, f0f80040, 368ea270)
     S("dft_vrank_geq1_register", 0, d8f56e08, f1400faf, 4aa28e5e, 8bc94e6f)
     S("codelet_t2bv_20_avx", 0, 8e5da34d, 71e1a432, adf90fac, 4997b0bf)
     S("codelet_t1bv_4_avx", 0, 8a8e21b7, bc426149, beb862d4, 14cdf08f)
     S("dft_vrank_geq1_register", 0, d3264b9e, 77681230, 876b954b, 352f2414)
     S("codelet_n1bv_64_avx", 0, 2911ff91, 535a4e85, 462850ab, 4e0f05f8)
     ")"},
    {5376, HEAD
     S("dft_vrank_geq1_register", 0, cd6a0745, 5c759256, 91cf318f, 916788b1)
     S("codelet_t1fv_7_avx", 0, 0135c905, 5091eb40, 4d7209bf, 879dab28)
     S("codelet_t1fv_64_avx", 0, 068b4a8b, 4c0cdb37, 0c75d17c, 0c9ca42e)
     S("codelet_n1fv_12_sse2", 0, 88137df8, 4db030ec, 91bcf416, c9696bd1)
     S("codelet_n1bv_64_avx", 0, 055f296e, 280c076b, 31b846b9, c192a241)
     S("codelet_t1bv_7_avx", 0, 86375a99, 956b550c, 2142c292, 4d6c4ec7)
     S("dft_vrank_geq1_register", 0, 1d64b4a4, 17f8e776, fa1c7432, bc043ec1)
     S("codelet_t2bv_4_avx", 0, 74bf9613, dd50f1ea, eeffa6ec, 73c33bc5)
     S("dft_vrank_geq1_register", 0, 2ca84f60, f6dd6e7d, 6119cf18, b63ea9c9)
     S("codelet_t1bv_3_avx", 0, bde03739, 79021760, 6016f8d2, 0a0aaee9)
     ")"},
    {6144, HEAD
     S("codelet_t1fv_3_avx", 0, 7acce9c8, a8ab181c, be1d22ce, e266ca10)
     S("codelet_n1fv_64_avx", 0, a429bb37, 138dc3c5, 57db5e2f, aa24207d)
     S("codelet_t2fv_32_avx", 0, 81cf1b9b, be70572e, 07e07bca, fe6c5be2)
     S("dft_vrank_geq1_register", 0, 6e366d27, eb595d05, 05687240, 9b9316fa)
     S("codelet_t1bv_12_avx", 0, 98b81ac6, 2dd6a636, e940733d, ccdbabcb)
     S("codelet_n1bv_128_avx", 0, 2c2281ea, 2ad95b34, 5b4a1b26, 2c6a4146)
     S("codelet_t2bv_4_avx", 0, 9e63ea99, 8f46313b, 0dbe723a, 9604ea44)
     S("dft_vrank_geq1_register", 0, 36946e16, c3402d96, 6ff533b0, 04316d46)
     ")"},
    {6400, HEAD
     S("codelet_t2fv_20_avx", 0, ef2ba2c4, a3569c8a, 9ffd84e7, a2db8f94)
     S("dft_vrank_geq1_register", 0, 1ae66b10, 9e2a8cbc, e10355ba, e4d24cfd)
     S("codelet_t2fv_20_avx", 0, 535f69f5, c5d487c3, c57d0003, 01bd2eec)
     S("codelet_t1fv_2_sse2", 0, af1ca0e5, 1cb5de14, 4833914d, bfd11525)
     S("codelet_n1fv_8_avx", 0, 4534477a, c0dc04c6, 96aa228a, 4a80a008)
     S("dft_vrank_geq1_register", 0, c5361001, 08ce94ba, 4a4ed26f, 0ebc2493)
     S("dft_vrank_geq1_register", 0, 26784102, 98c6cfb4, 2ce34172, 20491d7e)
     S("codelet_t2bv_20_avx", 0, 8953f2de, 05e2fe59, 85a249da, 607e927b)
     S("codelet_t1bv_20_avx", 0, 7383755b, bb36f3d2, 5864863f, d78f04f0)
     S("codelet_n1bv_16_avx", 0, 54754f95, 7f47d6f1, aacc6fc4, a928466e)
     ")"},
    {7168, HEAD
     S("codelet_t1fv_7_avx", 0, 59c0bd90, ac42d536, da71e0f3, fd39155c)
     S("dft_vrank_geq1_register", 0, c231d4d5, 8b0fb50a, f9e06d0b, 3ee286c1)
     S("codelet_t2fv_32_avx", 0, 9012d714, 327b7543, 7b5a6980, 6215649f)
     S("codelet_n1fv_8_avx", 0, f266bc03, 79f90a04, 0ac5469f, bb0e87bf)
     S("dft_vrank_geq1_register", 0, 20aaa4c3, b3fcecd4, a7975f77, e60c89e5)
     S("codelet_t2fv_4_avx", 0, 66108b4f, f14de5c4, 2cf558b9, ac88159b)
     S("codelet_n1bv_32_avx", 0, 7dd9185e, 97959df2, e184fb51, b8636a99)
     S("dft_vrank_geq1_register", 0, e8335312, d50d4a4e, b3707496, 71bc13ab)
     S("codelet_t2bv_4_sse2", 0, bcea8c2b, 8dd50e14, 22855dc3, f22b7825)
     S("dft_vrank_geq1_register", 0, 340943b2, 01e4ab88, 42e7dfda, 25f77452)
     S("codelet_t1bv_7_avx", 0, cd88a9a1, 61294e2f, 7ebd78b7, a807ba70)
     S("codelet_t2bv_8_avx", 0, 08e48423, 30adae04, bcc0e159, 5b08e10c)
     ")"},
    {7680, HEAD
     S("dft_vrank_geq1_register", 0, b778ac46, 8adf93ef, 1654e7ba, 307f8c3d)
     S("codelet_t1fv_32_avx", 0, a7fc66a0, 7e25d954, 01803f59, a811091b)
     S("codelet_t2fv_20_avx", 0, 05fcf3b0, 9621e803, e2769bc7, 2514ac66)
     S("codelet_n1fv_12_avx", 0, e1c2c125, 7adfa1a7, 126da39c, e7dc4dd1)
     S("codelet_t1bv_3_avx", 0, ea7cb7b1, 7e087516, bdc05ca9, 4d273c41)
     S("codelet_t2bv_20_avx", 0, c3818f87, 45811d84, fafc9f00, ea27deaa)
     S("codelet_n1bv_128_avx", 0, 2c68a1cc, 72263a19, 4166ab40, a84be623)
     S("dft_vrank_geq1_register", 0, 7070569f, e65bb2e6, 62db74b5, 6dee47f3)
     ")"},
    {8192, HEAD
     S("codelet_t2fv_64_avx", 0, 84b4edf1, e2d8b4a4, 8c99cc19, 1d18fc7d)
     S("codelet_t2fv_4_avx", 0, 5d434298, 88e29877, adad8a78, 52119eab)
     S("dft_vrank_geq1_register", 0, 697b20b6, 6432f0af, b6a1bcf0, 310827eb)
     S("codelet_n1fv_32_avx", 0, ea294cb6, 67ec5472, f523d9e6, 4fea7ced)
     S("codelet_n1bv_64_avx", 0, 961ce71f, 59de6052, 66f939c8, fcc9299f)
     S("codelet_t1bv_64_avx", 0, 5ff9bccd, dc2a85f0, 61c44a1b, c9c85ea2)
     S("codelet_t1bv_2_avx", 0, f06b0ac4, 8ab72ac2, 63b670d4, f83e4dff)
     S("dft_vrank_geq1_register", 0, b2c3c9fa, d38b8fd8, a222b9c2, 396eb78b)
     ")"},
    {9216, HEAD
     S("dft_vrank_geq1_register", 0, 3bd5add1, 0019268d, c58c66a8, 22b88414)
     S("codelet_t1fv_12_avx", 0, e933193f, 4574ea99, be5e4048, a2b13c89)
     S("codelet_t1fv_6_avx", 0, 66f05632, 21d4c04d, 1404ed65, 62651cd3)
     S("codelet_n1fv_128_avx", 0, f97fd2b7, 587e90d5, 3970e901, 88a07ca7)
     S("dft_vrank_geq1_register", 0, 6cc3c326, 1597726c, 32049ce2, 1d91306b)
     S("codelet_t2bv_4_avx", 0, 0425a687, bc759dd5, 24cd255c, 3172226f)
     S("codelet_n1bv_64_avx", 0, d7e9c176, c164989f, 638e3396, a86b0f18)
     S("codelet_t1bv_3_avx", 0, e6f6e46d, dd3da549, 4adcf506, bc452e11)
     S("codelet_t1bv_12_avx", 0, 3eafe00d, 4e58e2e7, e4a482b5, 1ca78693)
     S("dft_vrank_geq1_register", 0, e687c1f2, 065f3a7b, ad2adb98, 6e36de63)
     ")"},
    {10240, HEAD
     S("codelet_t1fv_20_avx", 0, 0a7a1d90, 0b9807d7, c700182a, 70d79598)
     S("dft_vrank_geq1_register", 0, 9bd379f2, 234330a1, c60b2bf6, ab4edf1c)
     S("codelet_t2fv_4_avx", 0, 5f775fb2, 25092aa5, 34fe86f0, b23395cb)
     S("codelet_n1fv_128_avx", 0, b27a87c2, ac2a548a, 7abf4015, 670b7bdf)
     S("codelet_t2bv_4_avx", 0, 07524c55, eca3077d, eef81237, 930ea78c)
     S("codelet_n1bv_128_avx", 0, 91c00031, e5330ffc, 140f7682, aeb0b92c)
     S("dft_vrank_geq1_register", 0, 428ebda9, 36a75cfe, dcf78583, c5d7c7c9)
     S("codelet_t2bv_20_avx", 0, 9a99d1f8, a5d740df, f68444ba, ea518011)
     ")"},
    {10752, HEAD
     S("codelet_t1fv_7_avx", 0, 028ca83e, bf3dd445, 9f5aa242, cfe4fcc5)
     S("codelet_t2fv_32_avx", 0, 2da1a202, 76a4441e, 8f6fd039, eb67afe0)
     S("dft_vrank_geq1_register", 0, eb3069ef, ae7e9082, 83c1459d, a3ec7479)
     S("codelet_n1fv_8_avx", 0, 0715ef85, 2bd23c3e, b2b29071, 1b6c7d36)
     S("codelet_t1fv_6_avx", 0, 9d1247f6, 3fa267ac, dd501485, b409a5c4)
     S("dft_vrank_geq1_register", 0, 06c91a8f, a39c631b, fecc33de, f64755e4)
     S("dft_vrank_geq1_register", 0, af3dcccb, 6e0d39d4, 679ee411, 24c0db29)
     S("dft_vrank_geq1_register", 0, ab47fce3, 6a9af3d7, 73ed25cf, 1b88252f)
     S("codelet_t1bv_7_avx", 0, 6bc7bbf0, 43e1dd88, 84fad2f6, 417e8f94)
     S("codelet_t2bv_32_avx", 0, 40be52fd, 2d9ea1c4, 949d58b6, de960441)
     S("codelet_n1bv_8_avx", 0, cf852602, 94374aa2, a3be4ff2, 7ff0b2b3)
     S("codelet_t1bv_6_avx", 0, d38bace0, f0003fa0, dd4aabc0, 604aad1b)
     ")"},
    {12288, HEAD
     S("codelet_t1fv_64_avx", 0, da561622, e8509e86, 3fcad5d6, a20ee080)
     S("codelet_t1fv_3_avx", 0, 96a7628d, 558fc28a, ecf389af, c20ff3a0)
     S("codelet_n1fv_64_avx", 0, 0560f5b6, 3fad750e, c2a41a94, 6dfda915)
     S("dft_vrank_geq1_register", 0, 735f9d34, fc67ea17, 81fb7ed8, 80f0f0e7)
     S("codelet_n1bv_64_avx", 0, f7244f1c, 7cdcea6d, 82ba2a7a, 05419400)
     S("codelet_t1bv_3_avx", 0, f71eba8a, baab40d2, 31f2d666, e3d94fbf)
     S("dft_vrank_geq1_register", 0, 0d20aaf2, 8e7c306b, efd386e3, 442b5746)
     S("codelet_t1bv_64_avx", 0, b2ecb1fe, d8214d7a, 4c9de976, 854992ef)
     ")"},
    {12800, HEAD
     S("codelet_t2fv_16_avx", 0, 3e0be181, 11c4d380, eb260b5f, 5acd2f2e)
     S("codelet_n1fv_20_avx", 0, 598aab0b, 14199b68, 0008284b, e5fef2dc)
     S("dft_vrank_geq1_register", 0, a3b4cb4e, a77df476, 4d3cea89, e6081afc)
     S("dft_vrank_geq1_register", 0, 0e053608, 2a255314, b3ef11e5, dffcd372)
     S("codelet_t1fv_2_avx", 0, 22026b90, 3308a7bb, 62a82eb8, 4ee7868a)
     S("codelet_t2fv_20_avx", 0, f888482d, 4a241243, 1efb1499, 8fc77f5d)
     S("codelet_t2bv_20_avx", 0, c7857426, 2f241d18, 0589eed2, e7e9995c)
     S("codelet_n1bv_16_avx", 0, 49c9f8de, 3812272c, 5860829f, 1d14b7b2)
     S("dft_vrank_geq1_register", 0, ef3688fd, 48d906ca, 3d4c844a, f51f3f77)
     S("codelet_t2bv_20_avx", 0, cc6a40cf, 11fc219b, f6e6a261, 9149c967)
     S("codelet_t1bv_2_avx", 0, 72c80783, 846cb443, a585ba68, b2981e1c)
     S("dft_vrank_geq1_register", 0, a967da0c, 86b3f79b, 6b2f6e29, a2aacd27)
     ")"},
    {14336, HEAD
     S("codelet_t2fv_32_avx", 0, 068c30d9, 928f59d7, 0d6ef9b6, c37a5d1c)
     S("dft_vrank_geq1_register", 0, e76ca47c, d4b822cc, 2836e02f, 7770c714)
     S("codelet_n1fv_64_avx", 0, be5f64d0, d0a61128, 3bbe7dd4, bf1aa3a8)
     S("codelet_t1fv_7_avx", 0, 18c0da9b, ad9d5134, 72eb0542, 6a8ab122)
     S("dft_vrank_geq1_register", 0, aeac15b2, 9a57d649, a31465d6, f4a0e1f8)
     S("codelet_t2bv_32_avx", 0, 68712539, d8bae7a4, 56c74663, 99fcade0)
     S("codelet_n1bv_64_avx", 0, bd076334, f4762e21, 8b87aa50, 29ce2dc7)
     S("codelet_t1bv_7_avx", 0, b251ec51, 36c40897, c7797357, ae435beb)
     ")"},
    {15360, HEAD
     S("dft_vrank_geq1_register", 0, 0a77382e, 27bc990a, 3d7bf2db, f52f9037)
     S("dft_vrank_geq1_register", 0, 84288101, 60a01b58, b46db944, 353cee48)
     S("codelet_n1fv_8_avx", 0, 8a68aeb9, 85a99916, 97ee87ab, 35b4dce7)
     S("codelet_t2fv_32_avx", 0, 011530a3, c821be88, 01919fc2, 73a9a075)
     S("codelet_t2fv_4_avx", 0, fcfda79d, 722d1faf, 6ff4eb74, 36b502ee)
     S("codelet_t1fv_15_avx", 0, 7b39658e, c45d535b, bee6b05f, d0432f19)
     S("codelet_t1bv_15_avx", 0, 6175018c, 85d5c6ef, c9f2eeea, 3ec18a06)
     S("codelet_t2bv_4_avx", 0, 0753e06d, 853b6deb, a43e3c15, 4e599692)
     S("codelet_t2bv_32_avx", 0, 81ee3b16, 92b9d0dc, 46634574, 49e893cc)
     S("dft_vrank_geq1_register", 0, e2a4acf5, 65c6ba48, ac74d682, b3f9125b)
     S("dft_vrank_geq1_register", 0, 1b9f8c78, 2bb5dc14, d035ed56, 90409cdf)
     S("codelet_n1bv_8_avx", 0, 4de7946b, 5fcfa10d, 8788235a, 73f3cc25)
     ")"},
    {16384, HEAD
     S("codelet_n1fv_8_avx", 0, 7e82cb6f, dc87427d, 939f635c, a6007cf2)
     S("dft_vrank_geq1_register", 0, 8a755267, 6378e3be, 20af89ad, b4a633e9)
     S("codelet_t1fv_8_avx", 0, f1915d84, 56c4bdfa, 16f8d847, dbd3c190)
     S("codelet_t1fv_4_avx", 0, 5581a92a, 50f7726e, c7165997, 9c693627)
     S("dft_vrank_geq1_register", 0, f8b57f46, 3ba02e32, 372afb3e, 1198fbf4)
     S("codelet_t2fv_64_avx", 0, 5e20e1bb, 4ffffbbc, 9f798a16, d5a0ef89)
     S("dft_vrank_geq1_register", 0, 26631fd9, 53f442b2, d02b4b36, 7965400f)
     S("codelet_n1bv_8_sse2", 0, 3cf55ae6, b0b5d93a, 638a7fe2, 1f7fe9b9)
     S("codelet_t2bv_4_avx", 0, 65999d7d, 815ea638, 39ebed72, 071bb755)
     S("dft_vrank_geq1_register", 0, 2bda6d1f, 9d0b7712, d41e948c, 8ba0cf75)
     S("codelet_t1bv_2_avx", 0, a33f803b, 1d3d7036, 2bd76bc9, 1385cd33)
     S("codelet_t2bv_64_avx", 0, dc473089, 2b6cdb8c, 4c07bd5b, b95cf160)
     S("dft_vrank_geq1_register", 0, 78320e62, 8d78eed3, 01227243, 7989eccc)
     S("codelet_t2bv_4_avx", 0, bcc6e24b, 661f5f74, 0272a82a, 884ad34e)
     ")"},
};

const char *gp_fft_known(int n)
{
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (known[i].n == n)
            return known[i].wisdom;
    }
    return NULL;
}
