import { type ComponentChild, render } from "preact";
import { ClassButton, ClassHost } from "../tools/classroom/ClassHost";
import { ConfirmDialog } from "../ui/Dialog";
import { SiteHeader } from "../ui/site/SiteHeader";
import { Toasts } from "../ui/Toast";

interface PageProps {
  readonly current: "logs" | "puzzles";
  /** Whether it links to the other pages. */
  readonly links?: boolean;
  /** Whether a class can be opened and joined here. */
  readonly hasClass?: boolean;
}

/** Show a page: `content` below the header, with dialogs and notices over it. */
export function renderPage(content: ComponentChild, { current, links = true, hasClass = true }: PageProps): void {
  render(
    <>
      <SiteHeader current={current} links={links}>
        {hasClass && <ClassButton />}
      </SiteHeader>
      <main id="main" tabIndex={-1}>
        {content}
      </main>
      <ConfirmDialog />
      <ClassHost />
      <Toasts />
    </>,
    document.getElementById("app") as HTMLElement,
  );
}
