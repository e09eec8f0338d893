import "../style/index.css";
import "../tools/classroom/classroom.css";
import { useSignal } from "@preact/signals";
import { render } from "preact";
import { followedCode } from "../store/classroom";
import { ClassHost } from "../tools/classroom/ClassHost";
import { followPages } from "../tools/classroom/pages";
import { Button } from "../ui/Button";
import { kept } from "../ui/browser/kept";
import { Toasts } from "../ui/Toast";

/** Reasons for which a visitor was sent to this page. */
const REFUSALS: Readonly<Record<string, string>> = {
  "class.unknown": "There is no class with this code. It may have ended.",
  "class.locked": "The lecturer has locked this class: no one else can join.",
  "class.crowded": "This class is full.",
  "class.crowded_address":
    "This class has no more room for your network. Another network, such as mobile data, may have room.",
  "class.guesses": "Too many wrong codes came from this browser or its network. Wait a minute, then try again.",
};
const LENGTH = 6;

const letters = (text: string): string =>
  text
    .toUpperCase()
    .replace(/[^A-Z]/g, "")
    .slice(0, LENGTH);

/** The code that was typed last. A page that was refused shows it, so that a typing error can be seen. */
const typed = kept("gridbloom.class.typed", "", (value): value is string => typeof value === "string");

function Join() {
  const refused = useSignal(new URLSearchParams(location.search).get("refused"));
  const code = useSignal(refused.peek() === null ? "" : letters(typed.peek()));
  const isComplete = code.value.length === LENGTH;
  return (
    <main class="class-join" id="main">
      <h1>Join a class</h1>
      <p>Type the six letters that the lecturer shows. No account and no name are needed.</p>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (!isComplete) return;
          typed.value = code.value;
          location.assign(`/class/${code.value}`);
        }}
      >
        <label>
          Code
          <input
            class="field-text"
            autocomplete="off"
            autocapitalize="characters"
            spellcheck={false}
            value={code.value}
            onInput={(event) => {
              code.value = letters(event.currentTarget.value);
              event.currentTarget.value = code.value;
              refused.value = null;
            }}
          />
        </label>
        <Button kind="primary" size="large" submits disabled={!isComplete}>
          Join
        </Button>
      </form>
      {refused.value && <p role="alert">{REFUSALS[refused.value] ?? "This class cannot be joined now."}</p>}
    </main>
  );
}

/** Shown while the lecturer is on a page that cannot be followed. */
function Waiting() {
  return (
    <main class="class-join" id="main">
      <h1>You are in the class</h1>
      <p>The lecturer is on a page that cannot be followed. Once the lecturer opens another one, it appears here.</p>
    </main>
  );
}

followPages("other");
render(
  <>
    {followedCode === null ? <Join /> : <Waiting />}
    <ClassHost />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
