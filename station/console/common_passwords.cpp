#include "station/console/common_passwords.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace annulus {
namespace {

/// Words that passwords are made of again and again, in the places where annulus is used: lower case, with letters for
/// the digits and signs that stand for them.
constexpr std::string_view kWords[] = {"password",
                                       "passwort",
                                       "passphrase",
                                       "passcode",
                                       "passwd",
                                       "pass",
                                       "secret",
                                       "geheim",
                                       "himitsu",
                                       "letmein",
                                       "welcome",
                                       "willkommen",
                                       "youkoso",
                                       "hello",
                                       "hallo",
                                       "konnichiwa",
                                       "ohayo",
                                       "arigato",
                                       "goodmorning",
                                       "goodnight",
                                       "iloveyou",
                                       "loveyou",
                                       "love",
                                       "aishiteru",
                                       "daisuki",
                                       "forever",
                                       "always",
                                       "together",
                                       "friends",
                                       "friendship",
                                       "family",
                                       "mother",
                                       "father",
                                       "sister",
                                       "brother",
                                       "princess",
                                       "prince",
                                       "queen",
                                       "king",
                                       "sunshine",
                                       "moonlight",
                                       "starlight",
                                       "rainbow",
                                       "flower",
                                       "sakura",
                                       "sunflower",
                                       "butterfly",
                                       "summer",
                                       "winter",
                                       "spring",
                                       "autumn",
                                       "january",
                                       "february",
                                       "march",
                                       "april",
                                       "may",
                                       "june",
                                       "july",
                                       "august",
                                       "september",
                                       "october",
                                       "november",
                                       "december",
                                       "monday",
                                       "tuesday",
                                       "wednesday",
                                       "thursday",
                                       "friday",
                                       "saturday",
                                       "sunday",
                                       "today",
                                       "tomorrow",
                                       "yesterday",
                                       "weekend",
                                       "holiday",
                                       "birthday",
                                       "christmas",
                                       "football",
                                       "baseball",
                                       "basketball",
                                       "soccer",
                                       "hockey",
                                       "tennis",
                                       "golf",
                                       "judo",
                                       "karate",
                                       "sumo",
                                       "yakyuu",
                                       "dragon",
                                       "monkey",
                                       "tiger",
                                       "panther",
                                       "eagle",
                                       "falcon",
                                       "phoenix",
                                       "dolphin",
                                       "panda",
                                       "kitty",
                                       "doggy",
                                       "puppy",
                                       "kitten",
                                       "cat",
                                       "dog",
                                       "horse",
                                       "rabbit",
                                       "usagi",
                                       "neko",
                                       "inu",
                                       "bear",
                                       "wolf",
                                       "superman",
                                       "batman",
                                       "spiderman",
                                       "starwars",
                                       "pokemon",
                                       "pikachu",
                                       "naruto",
                                       "doraemon",
                                       "totoro",
                                       "gundam",
                                       "godzilla",
                                       "ninja",
                                       "samurai",
                                       "shogun",
                                       "master",
                                       "shadow",
                                       "hunter",
                                       "killer",
                                       "warrior",
                                       "soldier",
                                       "admin",
                                       "administrator",
                                       "administrateur",
                                       "root",
                                       "toor",
                                       "user",
                                       "username",
                                       "guest",
                                       "test",
                                       "testing",
                                       "tester",
                                       "demo",
                                       "default",
                                       "changeme",
                                       "change",
                                       "changeit",
                                       "please",
                                       "temp",
                                       "temporary",
                                       "temppass",
                                       "login",
                                       "logon",
                                       "signin",
                                       "access",
                                       "account",
                                       "system",
                                       "server",
                                       "service",
                                       "support",
                                       "manager",
                                       "operator",
                                       "operateur",
                                       "technician",
                                       "technik",
                                       "engineer",
                                       "developer",
                                       "office",
                                       "shop",
                                       "store",
                                       "company",
                                       "business",
                                       "customer",
                                       "booth",
                                       "annulus",
                                       "scanner",
                                       "scan",
                                       "station",
                                       "console",
                                       "measure",
                                       "glasses",
                                       "optician",
                                       "optics",
                                       "lens",
                                       "spectacles",
                                       "megane",
                                       "kiosk",
                                       "screen",
                                       "tablet",
                                       "computer",
                                       "laptop",
                                       "desktop",
                                       "internet",
                                       "network",
                                       "wireless",
                                       "wifi",
                                       "router",
                                       "modem",
                                       "windows",
                                       "linux",
                                       "debian",
                                       "ubuntu",
                                       "macintosh",
                                       "apple",
                                       "google",
                                       "facebook",
                                       "instagram",
                                       "twitter",
                                       "youtube",
                                       "amazon",
                                       "netflix",
                                       "microsoft",
                                       "samsung",
                                       "nintendo",
                                       "playstation",
                                       "xbox",
                                       "sony",
                                       "toyota",
                                       "honda",
                                       "nissan",
                                       "suzuki",
                                       "mazda",
                                       "yamaha",
                                       "mercedes",
                                       "porsche",
                                       "ferrari",
                                       "corvette",
                                       "mustang",
                                       "harley",
                                       "tokyo",
                                       "osaka",
                                       "kyoto",
                                       "nagoya",
                                       "yokohama",
                                       "sapporo",
                                       "fukuoka",
                                       "hiroshima",
                                       "sendai",
                                       "nippon",
                                       "nihon",
                                       "japan",
                                       "london",
                                       "paris",
                                       "berlin",
                                       "newyork",
                                       "america",
                                       "england",
                                       "germany",
                                       "france",
                                       "china",
                                       "michael",
                                       "jennifer",
                                       "jessica",
                                       "ashley",
                                       "daniel",
                                       "andrew",
                                       "joshua",
                                       "matthew",
                                       "anthony",
                                       "charlie",
                                       "thomas",
                                       "robert",
                                       "george",
                                       "nicole",
                                       "michelle",
                                       "samantha",
                                       "maggie",
                                       "hannah",
                                       "tanaka",
                                       "sato",
                                       "watanabe",
                                       "yamamoto",
                                       "nakamura",
                                       "kobayashi",
                                       "takahashi",
                                       "hiroshi",
                                       "takeshi",
                                       "kenji",
                                       "yuki",
                                       "haruka",
                                       "chocolate",
                                       "cookie",
                                       "banana",
                                       "orange",
                                       "cherry",
                                       "strawberry",
                                       "pepper",
                                       "ginger",
                                       "coffee",
                                       "whisky",
                                       "sushi",
                                       "ramen",
                                       "money",
                                       "dollar",
                                       "golden",
                                       "silver",
                                       "diamond",
                                       "platinum",
                                       "purple",
                                       "black",
                                       "white",
                                       "green",
                                       "blue",
                                       "red",
                                       "yellow",
                                       "pink",
                                       "freedom",
                                       "liberty",
                                       "justice",
                                       "peace",
                                       "happy",
                                       "lucky",
                                       "smile",
                                       "angel",
                                       "heaven",
                                       "jesus",
                                       "christ",
                                       "blessed",
                                       "trustno",
                                       "trust",
                                       "nobody",
                                       "nothing",
                                       "whatever",
                                       "something",
                                       "anything",
                                       "qwerty",
                                       "qwertz",
                                       "azerty",
                                       "asdf",
                                       "zxcv",
                                       "correcthorsebatterystaple",
                                       "correct",
                                       "battery",
                                       "staple",
                                       "opensesame",
                                       "sesame",
                                       "abracadabra",
                                       "magic",
                                       "wizard",
                                       "merlin",
                                       "gandalf",
                                       "hobbit",
                                       "matrix",
                                       "keyboard",
                                       "mouse",
                                       "enter",
                                       "open",
                                       "security",
                                       "secure",
                                       "safe",
                                       "private",
                                       "hidden",
                                       "number",
                                       "one",
                                       "two",
                                       "three",
                                       "four",
                                       "five",
                                       "six",
                                       "seven",
                                       "eight",
                                       "nine",
                                       "ten",
                                       "the",
                                       "my",
                                       "your",
                                       "our",
                                       "this",
                                       "that",
                                       "is",
                                       "and",
                                       "for",
                                       "not",
                                       "new",
                                       "old",
                                       "big",
                                       "a",
                                       "i",
                                       "in",
                                       "it",
                                       "to",
                                       "me",
                                       "you",
                                       "we"};

/// Rows that fingers run along; also read backwards and round and round.
constexpr std::string_view kRows[] = {"abcdefghijklmnopqrstuvwxyz",
                                      "0123456789",
                                      "1234567890",
                                      "qwertyuiop",
                                      "qwertzuiop",
                                      "azertyuiop",
                                      "asdfghjkl",
                                      "zxcvbnm",
                                      "yxcvbnm",
                                      "1qaz2wsx3edc4rfv5tgb6yhn7ujm",
                                      "!@#$%^&*()",
                                      "!\"#$%&'()",
                                      "qazwsxedcrfvtgbyhnujm"};

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

/// "p4$$w0rd" as "password".
std::string WithLettersForSigns(std::string text) {
  constexpr std::string_view kSigns = "0134578@$!|+(";
  constexpr std::string_view kLetters = "oieastbasilto";
  static_assert(kSigns.size() == kLetters.size());
  for (char& c : text) {
    if (const std::size_t at = kSigns.find(c); at != std::string_view::npos) c = kLetters[at];
  }
  return text;
}

bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (static_cast<unsigned char>(c) & 0x80U) != 0; }

/// A short piece again and again, the last time perhaps cut short.
bool RepeatsItself(const std::string& text) {
  for (std::size_t period = 1; 2 * period <= text.size(); ++period) {
    if (text.compare(period, std::string::npos, text, 0, text.size() - period) == 0) return true;
  }
  return false;
}

/// Length of the longest beginning of `text` that runs along a row, of at least three characters.
std::size_t RunLength(std::string_view text) {
  std::size_t longest = 0;
  for (const std::string_view row : kRows) {
    for (const int direction : {1, -1}) {
      const std::size_t start = row.find(text.front());
      if (start == std::string_view::npos) continue;
      const auto size = static_cast<int>(row.size());
      int at = static_cast<int>(start);
      std::size_t length = 0;
      while (length < text.size() && text[length] == row[static_cast<std::size_t>(at)]) {
        at = (at + direction + size) % size;
        ++length;
      }
      longest = std::max(longest, length);
    }
  }
  return longest >= 3 ? longest : 0;
}

/// How many characters of `text` cannot be explained by well-known words, rows, and what is put around them; the least
/// over all ways to take it apart. Digits and signs count a quarter: they are what is added to a word. In quarters.
std::size_t UnexplainedQuarters(const std::string& text, const std::vector<std::string_view>& words) {
  std::vector<std::size_t> least(text.size() + 1, 4 * text.size());
  least[0] = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t own = least[i] + (IsLetter(text[i]) ? 4 : 1);
    least[i + 1] = std::min(least[i + 1], own);
    const std::string_view rest = std::string_view(text).substr(i);
    for (const std::string_view word : words) {
      if (rest.starts_with(word)) least[i + word.size()] = std::min(least[i + word.size()], least[i] + 1);
    }
    if (const std::size_t run = RunLength(rest); run > 0) least[i + run] = std::min(least[i + run], least[i] + 1);
  }
  return least[text.size()];
}

}  // namespace

bool IsCommonPassword(std::string_view password, std::string_view user) {
  // What may be left when words and rows are taken out: two letters and a year, or the like. Every word costs one
  // quarter too, so that a sentence of many words, which is hard to guess, is let through.
  constexpr std::size_t kMayBeLeft = 9;
  constexpr std::size_t kManyWords = 4;
  const std::string lower = Lower(password);
  if (RepeatsItself(lower)) return true;
  std::vector<std::string_view> words(std::begin(kWords), std::end(kWords));
  const std::string name = Lower(user);
  if (name.size() >= 3) words.push_back(name);
  const std::size_t blanks = static_cast<std::size_t>(std::count(lower.begin(), lower.end(), ' '));
  if (blanks >= kManyWords) return false;
  const std::string plain = WithLettersForSigns(lower);
  const std::size_t left = std::min(UnexplainedQuarters(lower, words), UnexplainedQuarters(plain, words));
  return left < kMayBeLeft;
}

}  // namespace annulus
