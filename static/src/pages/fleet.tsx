import "../style/index.css";
import "./logs/library/library.css";
import "./fleet/fleet.css";
import { render } from "preact";
import { ClassButton, ClassHost } from "../tools/classroom/ClassHost";
import { showOther } from "../tools/classroom/pages";
import { ConfirmDialog } from "../ui/Dialog";
import { SiteHeader } from "../ui/SiteHeader";
import { Toasts } from "../ui/Toast";
import { Fleet } from "./fleet/Fleet";

showOther();
render(
  <>
    <SiteHeader current="logs">
      <ClassButton />
    </SiteHeader>
    <main id="main" tabIndex={-1}>
      <Fleet />
    </main>
    <ConfirmDialog />
    <ClassHost />
    <Toasts />
  </>,
  document.getElementById("app") as HTMLElement,
);
