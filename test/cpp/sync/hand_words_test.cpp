// What a hand says belongs to the capture times from its own stamp on, whenever it arrives.
#include "yarm/sync/hand_words.hpp"

#include <gtest/gtest.h>

namespace {

using yarm::HandWords;

TEST(HandWords, AWordCountsFromItsStampOnAlsoWhenItComesBeforeTheSetBeforeIt) {
  HandWords words;
  words.say(100, false);
  words.say(120, true);
  words.say(140, false);
  EXPECT_TRUE(words.covers(140));
  EXPECT_FALSE(words.covers(141));
  EXPECT_FALSE(words.holdsAt(110));
  EXPECT_TRUE(words.holdsAt(120));
  EXPECT_TRUE(words.holdsAt(139));
  EXPECT_FALSE(words.holdsAt(150));
  EXPECT_FALSE(words.holds());
}

TEST(HandWords, AHandWithoutStampsCountsFromItsArrival) {
  HandWords words;
  EXPECT_TRUE(words.covers(1'000'000));
  words.say(true);
  EXPECT_TRUE(words.holdsAt(5));
  words.say(false);
  EXPECT_FALSE(words.holdsAt(6));
  words.say(std::int64_t{7}, true);
  words.say(false);
  EXPECT_TRUE(words.holdsAt(8));
  EXPECT_FALSE(words.covers(8));
}

TEST(HandWords, ANewRunForgetsTheOneBefore) {
  HandWords words;
  words.say(1000, true);
  words.say(10, false);
  EXPECT_FALSE(words.holdsAt(20));
  EXPECT_FALSE(words.covers(20));
  EXPECT_TRUE(words.covers(10));
}

}  // namespace
