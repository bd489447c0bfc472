// What every offscreen context promises: where pixels are, what is read back, that contexts keep apart.
// SPDX-License-Identifier: MIT
#include "hal/gl/offscreen_gl.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <thread>
#include <vector>

namespace cupola {
namespace {

using testing::HasSubstr;

using Pixel = std::array<int, 4>;

struct Picture {
  Picture(int w, int h, int padding = 0)
      : width(w),
        height(h),
        stride(4 * (w + padding)),
        bytes(static_cast<std::size_t>(stride * h), std::byte{0xee}) {}
  Pixel at(int x, int y) const {
    const std::byte* pixel = bytes.data() + y * stride + 4 * x;
    return {int(pixel[0]), int(pixel[1]), int(pixel[2]), int(pixel[3])};
  }
  bool read(OffscreenGl& context) { return context.read_back(bytes.data(), stride); }
  int width;
  int height;
  std::ptrdiff_t stride;
  std::vector<std::byte> bytes;
};

void clear(const GlFunctions& gl, float red, float green, float blue) {
  gl.clear_color(red, green, blue, 1.0F);
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

GLuint compile(const OffscreenGl& context, GLenum type, const char* text) {
  const GlFunctions& gl = context.gl();
  const char* parts[] = {
      context.description().es ? "#version 300 es\nprecision highp float;\n" : "#version 330\n", text};
  const GLuint shader = gl.create_shader(type);
  gl.shader_source(shader, 2, parts, nullptr);
  gl.compile_shader(shader);
  GLint compiled = 0;
  gl.get_shaderiv(shader, GL_COMPILE_STATUS, &compiled);
  EXPECT_EQ(compiled, 1);
  return shader;
}

// A triangle of pixel positions from the top left, at a depth from -1 (near) to 1.
struct Triangle {
  std::array<float, 6> corners;
  float depth;
  std::array<float, 3> colour;
};
void draw(const OffscreenGl& context, const std::vector<Triangle>& triangles) {
  const GlFunctions& gl = context.gl();
  const GLuint program = gl.create_program();
  gl.attach_shader(program,
                   compile(context, GL_VERTEX_SHADER,
                           "in vec3 position;\n"
                           "uniform vec2 size;\n"
                           "void main() {\n"
                           "  gl_Position = vec4(2.0 * position.x / size.x - 1.0,\n"
                           "                     1.0 - 2.0 * position.y / size.y, position.z, 1.0);\n"
                           "}\n"));
  gl.attach_shader(program, compile(context, GL_FRAGMENT_SHADER,
                                    "uniform vec3 colour;\n"
                                    "out vec4 pixel;\n"
                                    "void main() { pixel = vec4(colour, 1.0); }\n"));
  gl.bind_attrib_location(program, 0, "position");
  gl.link_program(program);
  gl.use_program(program);
  gl.uniform_2f(gl.get_uniform_location(program, "size"), static_cast<float>(context.description().width),
                static_cast<float>(context.description().height));
  GLuint array = 0;
  gl.gen_vertex_arrays(1, &array);
  gl.bind_vertex_array(array);
  GLuint buffer = 0;
  gl.gen_buffers(1, &buffer);
  gl.bind_buffer(GL_ARRAY_BUFFER, buffer);
  gl.enable_vertex_attrib_array(0);
  gl.vertex_attrib_pointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.enable(GL_DEPTH_TEST);
  for (const Triangle& one : triangles) {
    const auto& c = one.corners;
    const float data[] = {c[0], c[1], one.depth, c[2], c[3], one.depth, c[4], c[5], one.depth};
    gl.buffer_data(GL_ARRAY_BUFFER, sizeof data, data, GL_STREAM_DRAW);
    gl.uniform_3f(gl.get_uniform_location(program, "colour"), one.colour[0], one.colour[1], one.colour[2]);
    gl.draw_arrays(GL_TRIANGLES, 0, 3);
  }
  EXPECT_EQ(gl.get_error(), GLenum{GL_NO_ERROR});
}

class OffscreenGlTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    OpenedGl opened = open_offscreen_gl(64, 48, GetParam());
    if (!opened.context &&
        (GetParam() == std::string("egl-gbm") || GetParam() == std::string("egl-default"))) {
      GTEST_SKIP() << opened.refused.at(0).reason;
    }
    ASSERT_TRUE(opened.context) << opened.refused.at(0).reason;
    context_ = std::move(opened.context);
    ASSERT_TRUE(context_->make_current());
  }
  std::unique_ptr<OffscreenGl> context_;
};

TEST_P(OffscreenGlTest, SaysWhatItIs) {
  EXPECT_EQ(context_->description().context, GetParam());
  EXPECT_NE(context_->description().renderer, "");
  EXPECT_NE(context_->description().version, "");
  EXPECT_EQ(context_->description().width, 64);
  EXPECT_EQ(context_->description().height, 48);
}

TEST_P(OffscreenGlTest, ReadsBackTheColourItWasClearedTo) {
  clear(context_->gl(), 1.0F, 0.6F, 0.2F);
  Picture picture(64, 48);
  ASSERT_TRUE(picture.read(*context_));
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) ASSERT_EQ(picture.at(x, y), (Pixel{255, 153, 51, 255})) << x << " " << y;
  }
}

TEST_P(OffscreenGlTest, PutsEveryPixelOfATriangleWhereItBelongs) {
  clear(context_->gl(), 0.0F, 0.0F, 0.0F);
  // The right angle at the top left; no pixel's middle is on an edge.
  draw(*context_, {{{8, 4, 39.5F, 4, 8, 35.5F}, 0.0F, {1, 0, 1}}});
  Picture picture(64, 48);
  ASSERT_TRUE(picture.read(*context_));
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool inside = x >= 8 && y >= 4 && (x + 0.5 - 8) + (y + 0.5 - 4) < 31.5;
      ASSERT_EQ(picture.at(x, y), (inside ? Pixel{255, 0, 255, 255} : Pixel{0, 0, 0, 255})) << x << " " << y;
    }
  }
}

TEST_P(OffscreenGlTest, KeepsTheNearerOfTwoTriangles) {
  clear(context_->gl(), 0.0F, 0.0F, 0.0F);
  const std::array<float, 6> everywhere = {-100, -100, 300, -100, -100, 300};
  draw(*context_,
       {{everywhere, 0.5F, {1, 0, 0}}, {everywhere, -0.5F, {0, 1, 0}}, {everywhere, 0.0F, {0, 0, 1}}});
  Picture picture(64, 48);
  ASSERT_TRUE(picture.read(*context_));
  EXPECT_EQ(picture.at(0, 0), (Pixel{0, 255, 0, 255}));
  EXPECT_EQ(picture.at(63, 47), (Pixel{0, 255, 0, 255}));
}

TEST_P(OffscreenGlTest, LeavesWhatIsBetweenTheRowsAlone) {
  clear(context_->gl(), 0.0F, 0.0F, 1.0F);
  draw(*context_, {{{-100, -100, 300, -100, -100, 105.25F}, 0.0F, {1, 0, 0}}});
  Picture packed(64, 48);
  Picture padded(64, 48, 5);
  ASSERT_TRUE(packed.read(*context_));
  ASSERT_TRUE(padded.read(*context_));
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) ASSERT_EQ(padded.at(x, y), packed.at(x, y)) << x << " " << y;
    for (int x = 64; x < 69; ++x)
      ASSERT_EQ(padded.at(x, y), (Pixel{0xee, 0xee, 0xee, 0xee})) << x << " " << y;
  }
}

TEST_P(OffscreenGlTest, RefusesStridesThatHoldNoRow) {
  Picture picture(64, 48);
  for (const std::ptrdiff_t stride : {0, 252, 258, -256}) {
    EXPECT_FALSE(context_->read_back(picture.bytes.data(), stride)) << stride;
  }
  EXPECT_FALSE(context_->read_back(nullptr, 256));
  EXPECT_EQ(picture.at(0, 0), (Pixel{0xee, 0xee, 0xee, 0xee}));
}

TEST_P(OffscreenGlTest, KeepsItsFrameBesideOtherContexts) {
  for (const char* other_kind : {GetParam(), "egl-surfaceless", "osmesa"}) {
    OpenedGl opened = open_offscreen_gl(31, 17, other_kind);
    ASSERT_TRUE(opened.context) << opened.refused.at(0).reason;
    OffscreenGl& other = *opened.context;
    for (int round = 0; round < 3; ++round) {
      ASSERT_TRUE(context_->make_current());
      clear(context_->gl(), 1.0F, 0.0F, 0.0F);
      ASSERT_TRUE(other.make_current());
      clear(other.gl(), 0.0F, 1.0F, 0.0F);
      draw(other, {{{0, 0, 20, 0, 0, 10.25F}, 0.0F, {0, 0, 1}}});
      Picture mine(64, 48);
      Picture others(31, 17);
      ASSERT_TRUE(context_->make_current());
      ASSERT_TRUE(mine.read(*context_));
      ASSERT_TRUE(other.make_current());
      ASSERT_TRUE(others.read(other));
      EXPECT_EQ(mine.at(0, 0), (Pixel{255, 0, 0, 255})) << other_kind;
      EXPECT_EQ(mine.at(63, 47), (Pixel{255, 0, 0, 255})) << other_kind;
      EXPECT_EQ(others.at(0, 0), (Pixel{0, 0, 255, 255})) << other_kind;
      EXPECT_EQ(others.at(30, 16), (Pixel{0, 255, 0, 255})) << other_kind;
    }
    opened.context.reset();
    ASSERT_TRUE(context_->make_current());
    Picture still(64, 48);
    ASSERT_TRUE(still.read(*context_));
    EXPECT_EQ(still.at(0, 0), (Pixel{255, 0, 0, 255})) << "after the other one's end";
  }
}

TEST_P(OffscreenGlTest, DrawsOnTwoThreadsAtOnce) {
  const auto paint = [](OffscreenGl& context, float red) {
    if (!context.make_current()) return;
    for (int i = 0; i < 20; ++i) {
      clear(context.gl(), red, 1.0F, 1.0F - red);
      Picture picture(64, 48);
      ASSERT_TRUE(picture.read(context));
      ASSERT_EQ(picture.at(i, i),
                (Pixel{static_cast<int>(255 * red), 255, static_cast<int>(255 * (1 - red)), 255}));
    }
  };
  std::thread elsewhere([&] {
    const OpenedGl opened = open_offscreen_gl(64, 48, GetParam());
    ASSERT_TRUE(opened.context);
    paint(*opened.context, 1.0F);
  });
  paint(*context_, 0.0F);
  elsewhere.join();
}

TEST_P(OffscreenGlTest, RefusesSizesThatAreNone) {
  for (const auto& [width, height] : {std::pair{0, 48}, {64, 0}, {-1, -1}, {1 << 20, 4}, {4, 1 << 20}}) {
    const OpenedGl opened = open_offscreen_gl(width, height, GetParam());
    EXPECT_FALSE(opened.context);
    ASSERT_EQ(opened.refused.size(), 1U);
    EXPECT_THAT(opened.refused[0].reason, HasSubstr("sides from 1 to"));
  }
  EXPECT_TRUE(open_offscreen_gl(1, 1, GetParam()).context);
}

INSTANTIATE_TEST_SUITE_P(All, OffscreenGlTest,
                         testing::Values("egl-surfaceless", "egl-gbm", "egl-default", "osmesa"),
                         [](const auto& kind) {
                           std::string name = kind.param;
                           for (char& each : name) each = each == '-' ? '_' : each;
                           return name;
                         });

TEST(OffscreenGlChoice, IsTheFirstThatWorksAndSaysWhyOthersDoNot) {
  const OpenedGl opened = open_offscreen_gl(8, 8);
  ASSERT_TRUE(opened.context);
  for (const GlRefusal& refusal : opened.refused) {
    EXPECT_NE(refusal.context, opened.context->description().context);
    EXPECT_NE(refusal.reason, "");
  }
}

TEST(OffscreenGlChoice, RefusesNamesThatAreNone) {
  const OpenedGl opened = open_offscreen_gl(8, 8, "vulkan");
  EXPECT_FALSE(opened.context);
  ASSERT_EQ(opened.refused.size(), 1U);
  EXPECT_EQ(opened.refused[0].context, "vulkan");
  EXPECT_THAT(opened.refused[0].reason, HasSubstr("expected egl-surfaceless"));
}

}  // namespace
}  // namespace cupola
