//! A client's questions about plans: of each kind one is answered at a time, and of those that come meanwhile the newest.

use std::future::{Future, pending};
use std::pin::Pin;

use axum::extract::ws::Utf8Bytes;

/// The making of an answer.
type Answer = Pin<Box<dyn Future<Output = Utf8Bytes> + Send + Sync>>;

/// Questions of one kind.
#[derive(Default)]
struct Lane {
    under_way: Option<Answer>,
    next: Option<Answer>,
}

impl Lane {
    fn ask(&mut self, answer: Answer) {
        if self.under_way.is_none() {
            self.under_way = Some(answer);
        } else {
            self.next = Some(answer);
        }
    }

    /// The next answer; waits for ever while nothing is asked. Nothing is lost when it is given up and called again.
    async fn answered(&mut self) -> Utf8Bytes {
        let Some(answer) = &mut self.under_way else { return pending().await };
        let text = answer.await;
        self.under_way = self.next.take();
        text
    }
}

/// Questions of one client.
#[derive(Default)]
pub struct Questions {
    assessments: Lane,
    ways: Lane,
}

impl Questions {
    /// Asks for an assessment, which may take a while.
    pub fn ask_assessment(&mut self, answer: impl Future<Output = Utf8Bytes> + Send + Sync + 'static) {
        self.assessments.ask(Box::pin(answer));
    }

    /// Asks for a way, which waits for no assessment.
    pub fn ask_way(&mut self, answer: impl Future<Output = Utf8Bytes> + Send + Sync + 'static) {
        self.ways.ask(Box::pin(answer));
    }

    /// The next answer of either kind; waits for ever while nothing is asked.
    pub async fn answered(&mut self) -> Utf8Bytes {
        tokio::select! {
            text = self.ways.answered() => text,
            text = self.assessments.answered() => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::future::ready;

    use tokio::sync::oneshot;

    use super::*;

    #[tokio::test]
    async fn of_those_that_wait_the_newest_is_answered_and_a_way_waits_for_no_assessment() {
        let mut questions = Questions::default();
        let text = Utf8Bytes::from_static;
        let (done, flown) = oneshot::channel();
        questions.ask_assessment(async { flown.await.expect("an answer") });
        questions.ask_assessment(ready(text("superseded")));
        questions.ask_assessment(ready(text("second")));
        questions.ask_way(ready(text("way")));
        assert_eq!(questions.answered().await, text("way"));
        done.send(text("first")).expect("it is waited for");
        assert_eq!(questions.answered().await, text("first"));
        assert_eq!(questions.answered().await, text("second"));
        assert!(tokio::time::timeout(std::time::Duration::ZERO, questions.answered()).await.is_err());
    }
}
