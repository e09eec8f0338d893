import "../style/index.css";
import "./missing.css";
import { render } from "preact";
import { Button } from "../ui/Button";
import { SiteHeader } from "../ui/site/SiteHeader";

/** The page for an unknown address. */
function Missing() {
  return (
    <main class="missing-page" id="main" tabIndex={-1}>
      <h1>There is no page at this address</h1>
      <p>
        <code>{location.pathname}</code>
      </p>
      <p>Check the address for mistakes, or open one of these pages:</p>
      <div class="choices">
        <Button kind="primary" href="/lab.html">
          Lab
        </Button>
        <Button href="/lecture.html">Lecture</Button>
        <Button href="/logs.html">Logs</Button>
        <Button href="/puzzles.html">Puzzles</Button>
      </div>
    </main>
  );
}

render(
  <>
    <SiteHeader current="none" />
    <Missing />
  </>,
  document.getElementById("app") as HTMLElement,
);
