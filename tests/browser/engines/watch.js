// The first script of every page in these tests: it keeps what goes wrong, for the test to judge at its end.
// WebDriver does not tell of it, so the page does, in the same way in each engine.
(() => {
  const KEY = "engines.problems";
  let isLeaving = false;
  const keep = (text) => {
    const all = JSON.parse(sessionStorage.getItem(KEY) ?? "[]");
    sessionStorage.setItem(KEY, JSON.stringify([...all, `${text} (on ${location.pathname}${location.search})`]));
  };
  const { error } = console;
  console.error = (...words) => {
    keep(`console: ${words.join(" ")}`);
    error.apply(console, words);
  };
  for (const name of ["beforeunload", "pagehide"])
    addEventListener(name, () => {
      isLeaving = true; // what was asked for last is not waited for
    });
  addEventListener(
    "error",
    ({ message, filename, lineno, target }) => {
      if (message?.startsWith("ResizeObserver loop completed")) return; // the rest is laid out in the next frame
      keep(message ? `uncaught: ${message} (${filename}:${lineno})` : `not loaded: ${target.src ?? target.href}`);
    },
    true,
  );
  addEventListener("unhandledrejection", ({ reason }) => keep(`unhandled: ${reason}`));
  addEventListener("securitypolicyviolation", (found) =>
    keep(`against the policy: ${found.violatedDirective}, ${found.blockedURI}`),
  );
  new PerformanceObserver((list) => {
    for (const { name } of list.getEntries())
      if (/^(http|ws)/.test(name) && new URL(name).host !== location.host) keep(`asked another host: ${name}`);
  }).observe({ type: "resource", buffered: true });
  const ask = window.fetch;
  window.fetch = async (...given) => {
    const address = given[0]?.url ?? given[0];
    try {
      const answer = await ask(...given);
      if (!answer.ok) keep(`status ${answer.status}: ${address}`);
      return answer;
    } catch (found) {
      if (found.name !== "AbortError" && !isLeaving) keep(`request failed: ${address}: ${found}`);
      throw found;
    }
  };
  window.XMLHttpRequest = class extends XMLHttpRequest {
    constructor() {
      super();
      this.addEventListener("load", () => this.status < 400 || keep(`status ${this.status}: ${this.responseURL}`));
      this.addEventListener("error", () => isLeaving || keep("request failed"));
    }
  };
  window.WebSocket = class extends WebSocket {
    constructor(...given) {
      super(...given);
      this.addEventListener("error", () => isLeaving || keep(`socket failed: ${given[0]}`));
    }
  };
})();
