// Words of the page, by key; {name} stands for a value.

const book = { words: {}, language: "en", titles: {} };

export const LANGUAGES = { en: "English", ja: "日本語", de: "Deutsch" };

export function setWords(language, words, english) {
  book.words = { ...english, ...words };
  book.language = language;
  document.documentElement.lang = language;
}

export function t(key, values = {}) {
  const text = book.words[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ""));
}

export function setTitles(titles) {
  book.titles = titles;
}

// What people call an effect: those of the catalogue by their titles, others by their names.
export function titleOf(name) {
  return book.titles[name] ?? name.replaceAll("_", " ");
}

export function language() {
  return book.language;
}
