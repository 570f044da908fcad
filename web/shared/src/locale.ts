// To be imported first. WebKit on Linux passes the locale "C" of its environment on as a language, which Intl refuses, and
// uPlot formats numbers in the language of the browser when it is loaded.
try {
  new Intl.NumberFormat(navigator.language);
} catch {
  Object.defineProperty(navigator, 'language', { value: 'en' });
}
