// Faces from stills, numbered files, atlases and videos.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "pipeline/frame/y4m_writer.h"
#include "pipeline/source/file_source.h"
#include "pipeline/source/numbered_files.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kFour = {"front", "left", "right", "top"};
constexpr Size kFace{16, 12};

template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

std::vector<NeededRegion> all_of(const FaceSource& source) {
  std::vector<NeededRegion> needed;
  for (const Size size : source.face_sizes()) needed.push_back(NeededRegion::all(size));
  return needed;
}

ImageBuffer picture(std::uint32_t seed, PixelFormat format = PixelFormat::kRgbPlanar8) {
  return noise_picture(format, kFace, seed);
}

void write_picture(const std::filesystem::path& path, const Image& image) {
  std::filesystem::create_directories(path.parent_path());
  write_png(path, image);
}

// Frames 1 to `last` of each view; the picture is number * 10 + the view's place.
void write_sequence(const std::filesystem::path& folder, const std::string& pattern, std::int64_t last,
                    const std::vector<std::string>& views = kFour) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string of_view = pattern_of_view((folder / pattern).string(), views[i]);
    for (std::int64_t number = 1; number <= last; ++number) {
      write_picture(
          numbered_file(of_view, number),
          picture(static_cast<std::uint32_t>(number * 10) + static_cast<std::uint32_t>(i)).pixels());
    }
  }
}

void expect_frame(const FaceSet& faces, std::int64_t number) {
  ASSERT_EQ(faces.faces.size(), kFour.size());
  for (std::size_t i = 0; i < kFour.size(); ++i) {
    const ImageBuffer expected =
        picture(static_cast<std::uint32_t>(number * 10) + static_cast<std::uint32_t>(i));
    EXPECT_EQ(largest_difference(faces.faces[i], expected.pixels()), 0) << kFour[i] << " of file " << number;
  }
}

TEST(Stills, NeverEndAndNeverChange) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < 4; ++i) {
    files.push_back(folder / (kFour[i] + ".png"));
    write_picture(files.back(), picture(10 + static_cast<std::uint32_t>(i)).pixels());
  }
  const auto source = open_stills(files);
  EXPECT_EQ(source->length(), std::nullopt);
  EXPECT_EQ(source->format(), PixelFormat::kRgbPlanar8);
  EXPECT_THAT(source->face_sizes(), ElementsAre(kFace, kFace, kFace, kFace));
  source->prepare(all_of(*source));
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  expect_frame(faces, 1);
  EXPECT_EQ(source->fetch(123'456, faces), Fetch::kUnchanged);
  EXPECT_EQ(faces.frame, 123'456);
  expect_frame(faces, 1);
}

TEST(Stills, OfMixedDepthsAreAllWidenedTo16Bits) {
  const TemporaryFolder folder;
  const ImageBuffer narrow = picture(1), wide = picture(2, PixelFormat::kRgbPlanar16);
  write_picture(folder / "a.png", narrow.pixels());
  write_picture(folder / "b.png", wide.pixels());
  const std::vector<std::filesystem::path> files = {folder / "a.png", folder / "b.png"};
  const auto source = open_stills(files);
  EXPECT_EQ(source->format(), PixelFormat::kRgbPlanar16);
  source->prepare(all_of(*source));
  FaceSet faces;
  source->fetch(0, faces);
  EXPECT_EQ(sample(faces.faces[0], 1, 5, 6), 257 * sample(narrow, 1, 5, 6));
  EXPECT_EQ(largest_difference(faces.faces[1], wide.pixels()), 0);
}

TEST(Stills, ThatAreDamagedAreRefusedBeforeTheFirstFrame) {
  const TemporaryFolder folder;
  write_picture(folder / "a.png", picture(1).pixels());
  std::string file = read_text(folder / "a.png");
  file[file.size() / 2] = static_cast<char>(file[file.size() / 2] ^ 1);
  write_text(folder / "a.png", file);
  const std::vector<std::filesystem::path> files = {folder / "a.png"};
  const auto source = open_stills(files);
  EXPECT_THAT(refusal([&] { source->prepare(all_of(*source)); }), HasSubstr("damaged"));
  const std::vector<std::filesystem::path> missing = {folder / "b.png"};
  EXPECT_THAT(refusal([&] { open_stills(missing); }), HasSubstr("b.png"));
}

TEST(Sequence, TellsWhatDiffersFromTheFrameBefore) {
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16}) {
    const TemporaryFolder folder;
    const Size size{70, 40};  // three cells across, two down
    ImageBuffer front = noise_picture(format, size, 1);
    ImageBuffer top = noise_picture(format, size, 2);
    for (int number = 1; number <= 4; ++number) {
      if (number == 2) top.pixels().planes[1].row(39)[66 * sample_bytes(format)] ^= std::byte{1};
      if (number == 4) front.pixels().planes[0].row(0)[0] ^= std::byte{128};
      write_picture(folder / ("front_" + std::to_string(number) + ".png"), front.pixels());
      write_picture(folder / ("top_" + std::to_string(number) + ".png"), top.pixels());
    }
    WorkerPool pool(2);
    const std::vector<std::string> views = {"front", "top"};
    const auto source = open_sequence((folder / "{view}_%d.png").string(), views, {}, &pool);
    source->prepare(all_of(*source));
    FaceSet faces;
    EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
    EXPECT_TRUE(faces.changed.empty()) << "anything may differ from what was there before";
    EXPECT_EQ(source->fetch(1, faces), Fetch::kNew);
    ASSERT_EQ(faces.changed.size(), 2U);
    EXPECT_EQ(faces.changed[0].count(), 0);
    EXPECT_EQ(faces.changed[1].count(), 1);
    EXPECT_TRUE(faces.changed[1].touches(66, 39, 67, 40));
    EXPECT_EQ(source->fetch(2, faces), Fetch::kUnchanged);
    EXPECT_EQ(faces.frame, 2);
    EXPECT_EQ(source->fetch(3, faces), Fetch::kNew);
    EXPECT_EQ(faces.changed[0].count(), 1);
    EXPECT_EQ(faces.changed[1].count(), 0);
    EXPECT_EQ(source->fetch(0, faces), Fetch::kNew) << "around the loop";
    EXPECT_EQ(faces.changed[0].count() + faces.changed[1].count(), 2);
  }
}

TEST(Sequence, DoesNotDecodeAFileTwiceNorTakeADroppedOneForShown) {
  const TemporaryFolder folder;
  const ImageBuffer a = noise_picture(PixelFormat::kRgbPlanar8, {40, 40}, 1);
  const ImageBuffer b = noise_picture(PixelFormat::kRgbPlanar8, {40, 40}, 2);
  // front: a b b a a a; top: a, a damaged one, a a a b.
  for (int number = 1; number <= 6; ++number) {
    write_picture(folder / ("front_" + std::to_string(number) + ".png"),
                  (number == 2 || number == 3 ? b : a).pixels());
    write_picture(folder / ("top_" + std::to_string(number) + ".png"), (number == 6 ? b : a).pixels());
  }
  std::string file = read_text(folder / "top_2.png");
  file[file.size() - 40] = static_cast<char>(file[file.size() - 40] ^ 1);
  write_text(folder / "top_2.png", file);
  const std::vector<std::string> views = {"front", "top"};
  const auto source = open_sequence((folder / "{view}_%d.png").string(), views);
  source->prepare(all_of(*source));
  FaceSet faces;
  const auto expect = [&](int frame, Fetch fetch, const ImageBuffer& front, const ImageBuffer& top,
                          std::int64_t repeated) {
    EXPECT_EQ(source->fetch(frame, faces), fetch) << frame;
    EXPECT_EQ(largest_difference(faces.faces[0], front.pixels()), 0) << frame;
    EXPECT_EQ(largest_difference(faces.faces[1], top.pixels()), 0) << frame;
    EXPECT_EQ(source->counts().repeated, repeated) << frame;
  };
  expect(0, Fetch::kNew, a, a, 0);
  expect(1, Fetch::kFailed, a, a, 0);  // front's b was read and dropped
  expect(2, Fetch::kNew, b, a, 0);
  expect(3, Fetch::kNew, a, a, 1);
  expect(4, Fetch::kUnchanged, a, a, 3);
  expect(5, Fetch::kNew, a, b, 4);
  EXPECT_EQ(faces.changed[0].count(), 0);
  EXPECT_GT(faces.changed[1].count(), 0);
  expect(3, Fetch::kNew, a, a, 5);
}

TEST(Sequence, ComparesWithTheLastGoodFrameAfterABadOne) {
  const TemporaryFolder folder;
  const ImageBuffer first = noise_picture(PixelFormat::kRgbPlanar8, {40, 40}, 1);
  write_picture(folder / "front_1.png", first.pixels());
  write_picture(folder / "front_2.png", noise_picture(PixelFormat::kRgbPlanar8, {40, 40}, 2).pixels());
  write_picture(folder / "front_3.png", first.pixels());
  std::string file = read_text(folder / "front_2.png");
  file[file.size() - 40] = static_cast<char>(file[file.size() - 40] ^ 1);
  write_text(folder / "front_2.png", file);
  const std::vector<std::string> views = {"front"};
  const auto source = open_sequence((folder / "front_%d.png").string(), views);
  source->prepare(all_of(*source));
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  EXPECT_EQ(source->fetch(1, faces), Fetch::kFailed);
  EXPECT_EQ(source->fetch(2, faces), Fetch::kUnchanged) << "since the frame that stands";
}

TEST(Sequence, PlaysEveryPatternOfTheField) {
  for (const char* pattern : {"{view}_%06d.png", "{view}/%06d.png", "frame_{letter}_%04d.png",
                              "frame_%c_%04d.png", "name_{view}_%06d.png", "{view}/name_{view}_%d.png"}) {
    const TemporaryFolder folder;
    write_sequence(folder.path(), pattern, 3);
    for (const std::string& given :
         {(folder / pattern).string(), folder.path().string()}) {  // or only the folder
      const auto source = open_sequence(given, kFour);
      EXPECT_EQ(source->length(), 3) << pattern;
      source->prepare(all_of(*source));
      FaceSet faces;
      for (const int frame : {0, 1, 2, 0}) {
        EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
        EXPECT_EQ(faces.frame, frame);
        expect_frame(faces, frame + 1);
      }
      EXPECT_EQ(source->fetch(0, faces), Fetch::kUnchanged);
      EXPECT_EQ(source->fetch(3, faces), Fetch::kEnd);
      EXPECT_EQ(source->fetch(-1, faces), Fetch::kEnd);
      expect_frame(faces, 1);
    }
  }
}

TEST(Sequence, DecodesTheSameInParallel) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 4);
  WorkerPool pool(3);
  const auto source = open_sequence(folder.path().string(), kFour, {}, &pool);
  source->prepare(all_of(*source));
  FaceSet faces;
  for (int frame = 0; frame < 4; ++frame) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
    expect_frame(faces, frame + 1);
  }
}

TEST(Sequence, PlaysThePartFromInToOut) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 6);
  const std::string pattern = (folder / "{view}_%06d.png").string();
  const auto source = open_sequence(pattern, kFour, {.in = 3, .out = 5});
  EXPECT_EQ(source->length(), 3);
  source->prepare(all_of(*source));
  FaceSet faces;
  source->fetch(0, faces);
  expect_frame(faces, 3);
  EXPECT_EQ(open_sequence(pattern, kFour, {.in = 3, .out = {}})->length(), 4);
  EXPECT_EQ(open_sequence(pattern, kFour, {.in = {}, .out = 2})->length(), 2);
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour, {.in = 4, .out = 3}); }),
              HasSubstr("in is 4 and out is 3"));
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour, {.in = 0, .out = 3}); }),
              HasSubstr("front_000000.png: missing"));
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour, {.in = 1, .out = 1'000'000'000'000}); }),
              HasSubstr("front_000007.png: missing"));
}

TEST(Sequence, NamesTheFirstMissingFile) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 6);
  std::filesystem::remove(folder / "right_000004.png");
  std::filesystem::remove(folder / "left_000005.png");
  const std::string pattern = (folder / "{view}_%06d.png").string();
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour); }), HasSubstr("right_000004.png: missing"));
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour, {.in = 5, .out = 6}); }),
              HasSubstr("left_000005.png: missing"));
  std::filesystem::remove(folder / "top_000001.png");  // one view begins later than the others
  EXPECT_THAT(refusal([&] { open_sequence(pattern, kFour); }), HasSubstr("top_000001.png: missing"));
}

TEST(Sequence, RefusesPatternsThatCannotWork) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 1);
  const auto with = [&](const char* pattern, const std::vector<std::string>& views) {
    return refusal([&] { open_sequence((folder / pattern).string(), views); });
  };
  EXPECT_THAT(with("front_%06d.png", kFour), HasSubstr("expected {view} or {letter}"));
  EXPECT_EQ(with("front_%06d.png", {"front"}), "taken");
  EXPECT_THAT(with("{view}_000001.png", kFour), HasSubstr("expected one number"));
  EXPECT_THAT(with("{view}_%06d_%d.png", kFour), HasSubstr("expected one number"));
  EXPECT_THAT(with("{view}_%6d.png", kFour), HasSubstr("expected one number"));
  EXPECT_THAT(with("{view}_%s.png", kFour), HasSubstr("expected one number"));
  EXPECT_THAT(with("%06d/{view}.png", kFour), HasSubstr("expected one number"));
  EXPECT_THAT(with("{letter}_%06d.png", {"front", "camera"}), HasSubstr("view camera has no letter"));
  EXPECT_THAT(with("{view}_%04d.png", kFour), HasSubstr("no such files"));  // other digits
  EXPECT_THAT(with("{view}_%06d.png", {"front", "bottom"}), HasSubstr("bottom_%06d.png: no such files"));
  EXPECT_THAT(with("nowhere/{view}_%06d.png", kFour), HasSubstr("nowhere"));
}

TEST(Sequence, InAFolderMustBeTheOnlyOne) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal([&] { open_sequence(folder.path().string(), kFour); }),
              HasSubstr("expected for instance front/000001.png"));
  write_sequence(folder.path(), "day_{view}_%06d.png", 1);
  write_text(folder / "notes_front_1.txt", "not a picture");
  EXPECT_EQ(refusal([&] { open_sequence(folder.path().string(), kFour); }), "taken");
  write_sequence(folder.path(), "night_{view}_%06d.png", 1);
  EXPECT_THAT(refusal([&] { open_sequence(folder.path().string(), kFour); }), HasSubstr("several sequences"));
}

TEST(Sequence, KeepsTheLastGoodFacesWhileFilesAreMissingOrDamaged) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 5);
  const auto source = open_sequence(folder.path().string(), kFour);
  source->prepare(all_of(*source));
  FaceSet faces;
  std::filesystem::remove(folder / "left_000003.png");
  std::string file = read_text(folder / "top_000004.png");
  write_text(folder / "top_000004.png", file.substr(0, file.size() / 2));
  write_picture(folder / "front_000005.png", noise_picture(PixelFormat::kRgb8, {12, 16}).pixels());
  EXPECT_EQ(source->fetch(1, faces), Fetch::kNew);
  const char* causes[] = {"left_000003.png: No such file", "top_000004.png: the PNG is cut short",
                          "front_000005.png: the picture is 12 x 16; expected 16 x 12"};
  for (int frame = 2; frame < 5; ++frame) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kFailed);
    EXPECT_THAT(source->trouble(), HasSubstr(causes[frame - 2]));
    EXPECT_EQ(faces.frame, 1);
    expect_frame(faces, 2);
  }
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);  // and goes on afterwards
  expect_frame(faces, 1);
}

TEST(Sequence, IsBlackUntilTheFirstGoodFrame) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 2);
  const auto source = open_sequence(folder.path().string(), kFour);
  source->prepare(all_of(*source));
  std::filesystem::remove(folder / "left_000001.png");
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kFailed);
  ASSERT_EQ(faces.faces.size(), 4U);
  EXPECT_EQ(sample(faces.faces[0], 0, 3, 3), 0);
  EXPECT_EQ(source->fetch(1, faces), Fetch::kNew);
}

TEST(NeededRows, AreAllThatIsDecoded) {
  const TemporaryFolder folder;
  write_sequence(folder.path(), "{view}_%06d.png", 1);
  const auto source = open_sequence(folder.path().string(), kFour);
  std::vector<NeededRegion> needed(4, NeededRegion::none(kFace));
  needed[0] = NeededRegion::all(kFace);
  needed[1].include(3, 2);
  needed[1].include(9, 5);  // rows 2 to 5; 6 rows above and below
  needed[2].include(0, 0);  // row 0: 11 below
  source->prepare(needed);
  std::filesystem::remove(folder / "top_000001.png");  // not needed at all, not even opened
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  EXPECT_EQ(source->rows_skipped(), 0 + 8 + 11 + 12);
  const ImageBuffer front = picture(10), left = picture(11), right = picture(12);
  EXPECT_EQ(largest_difference(faces.faces[0], front.pixels()), 0);
  EXPECT_EQ(largest_difference(part_of(faces.faces[1], 0, 2, {16, 4}), part_of(left.pixels(), 0, 2, {16, 4})),
            0);
  EXPECT_EQ(largest_difference(row_of(faces.faces[2], 0), row_of(right.pixels(), 0)), 0);
}

// A 3 x 2 atlas: front right left / top bottom back, each cell another picture.
ImageBuffer atlas_picture(std::uint32_t seed) {
  return noise_picture(PixelFormat::kRgbPlanar8, {48, 24}, seed);
}
const AtlasLayout kLayout = {3, 2, {"front", "right", "left", "top", "bottom", "back"}};

void expect_atlas(const FaceSet& faces, const Image& atlas) {
  ASSERT_EQ(faces.faces.size(), 4U);
  const Size cells[] = {{0, 0}, {32, 0}, {16, 0}, {0, 12}};  // of front, left, right, top
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(faces.faces[i].size, kFace);
    EXPECT_EQ(largest_difference(faces.faces[i], part_of(atlas, cells[i].width, cells[i].height, kFace)), 0)
        << kFour[i];
  }
}

TEST(Atlas, GivesItsFacesInTheRigsOrderByName) {
  const TemporaryFolder folder;
  const ImageBuffer atlas = atlas_picture(1);
  write_picture(folder / "atlas.png", atlas.pixels());
  const auto source = open_atlas((folder / "atlas.png").string(), kLayout, kFour);
  EXPECT_EQ(source->length(), std::nullopt);
  source->prepare(all_of(*source));
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  expect_atlas(faces, atlas.pixels());
}

TEST(Atlas, MayBeASequence) {
  const TemporaryFolder folder;
  const ImageBuffer atlases[] = {atlas_picture(1), atlas_picture(2)};
  write_picture(folder / "a_0001.png", atlases[0].pixels());
  write_picture(folder / "a_0002.png", atlases[1].pixels());
  const auto source = open_atlas((folder / "a_%04d.png").string(), kLayout, kFour);
  EXPECT_EQ(source->length(), 2);
  source->prepare(all_of(*source));
  FaceSet faces;
  for (int frame = 0; frame < 2; ++frame) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
    expect_atlas(faces, atlases[frame].pixels());
  }
}

TEST(Atlas, MayBeAVideo) {
  const TemporaryFolder folder;
  const ImageBuffer atlas = smooth_picture(PixelFormat::kRgbPlanar8, {48, 24});
  Y4mWriter writer(folder / "a.y4m", {48, 24}, {30, 1});
  writer.write(atlas.pixels());
  writer.finish();
  const auto source = open_atlas((folder / "a.y4m").string(), kLayout, kFour);
  EXPECT_EQ(source->length(), 1);
  source->prepare(all_of(*source));
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  EXPECT_LE(largest_difference(faces.faces[1], part_of(atlas.pixels(), 32, 0, kFace)), 2);
}

TEST(Atlas, DecodesOnlyTheRowsThatItsFacesNeed) {
  const TemporaryFolder folder;
  write_picture(folder / "atlas.png", atlas_picture(1).pixels());
  const std::vector<std::string> views = {"front", "left"};  // both in the upper row of cells
  const auto source = open_atlas((folder / "atlas.png").string(), kLayout, views);
  source->prepare(all_of(*source));
  EXPECT_EQ(source->rows_skipped(), 12);
}

TEST(Atlas, IsRefusedWhenItDoesNotDivideOrLacksAView) {
  const TemporaryFolder folder;
  write_picture(folder / "atlas.png", atlas_picture(1).pixels());
  const auto with = [&](const AtlasLayout& layout) {
    return refusal([&] { open_atlas((folder / "atlas.png").string(), layout, kFour); });
  };
  EXPECT_THAT(with({5, 1, kLayout.faces}), HasSubstr("48 x 24 pixels do not divide into 5 columns"));
  EXPECT_THAT(with({0, 2, kLayout.faces}), HasSubstr("do not divide"));
  EXPECT_THAT(with({2, 2, kLayout.faces}), HasSubstr("6 faces named"));
  EXPECT_THAT(with({3, 1, {"front", "left", "right"}}),
              HasSubstr("no face for view top; its faces are front, left, right"));
  EXPECT_THAT(with({4, 1, {"front", "left", "right", "left"}}), HasSubstr("several faces for view left"));
}

TEST(Videos, RunInLockstepAndMustBeOfOneLength) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files = files_of_views((folder / "{view}.y4m").string(), kFour);
  const auto write = [&](std::size_t view, int frames) {
    Y4mWriter writer(files[view], kFace, {30, 1});
    for (int i = 0; i < frames; ++i) {
      ImageBuffer image(PixelFormat::kRgb8, kFace);
      for (int y = 0; y < kFace.height; ++y)
        for (int x = 0; x < 3 * kFace.width; ++x)
          image.pixels().samples<std::uint8_t>(0, y)[x] =
              static_cast<std::uint8_t>(50 * i + 10 * static_cast<int>(view));
      writer.write(image.pixels());
    }
    writer.finish();
  };
  for (std::size_t view = 0; view < 4; ++view) write(view, 3);
  const auto source = open_videos(files);
  EXPECT_EQ(source->length(), 3);
  source->prepare(all_of(*source));
  FaceSet faces;
  for (const int frame : {0, 2, 1}) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
    for (int view = 0; view < 4; ++view)
      EXPECT_NEAR(sample(faces.faces[static_cast<std::size_t>(view)], 1, 8, 8), 50 * frame + 10 * view, 1);
  }
  write(2, 2);
  EXPECT_THAT(refusal([&] { open_videos(files); }), HasSubstr("right.y4m: has 2 frames, but"));
  write_picture(files[3], picture(1).pixels());
  write(2, 3);
  EXPECT_THAT(refusal([&] { open_videos(files); }), HasSubstr("top.y4m: is a still"));
  EXPECT_THAT(refusal([&] { open_stills(files); }), HasSubstr("front.y4m: is a video"));
}

TEST(Videos, ThatShrinkWhileTheyPlayKeepTheLastGoodFrame) {
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> files = {folder / "a.y4m"};
  Y4mWriter writer(files[0], kFace, {30, 1});
  const ImageBuffer image = smooth_picture(PixelFormat::kRgb8, kFace);
  for (int i = 0; i < 3; ++i) writer.write(image.pixels());
  writer.finish();
  const auto source = open_videos(files);
  source->prepare(all_of(*source));
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  std::filesystem::resize_file(files[0], 700);
  EXPECT_EQ(source->fetch(2, faces), Fetch::kFailed);
  EXPECT_LE(largest_difference(faces.faces[0], image.pixels()), 2);
}

}  // namespace
}  // namespace cupola
