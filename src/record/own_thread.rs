//! A recorder on a thread of its own, so that the steps do not wait for it.
//!
//! Frames are copied into a fixed number of copies that go round: to the thread, and back when they are recorded. So the
//! queue is bounded, a run that is ahead of its recorder waits, no frame is dropped, and nothing is allocated once the
//! copies have grown. The recorder sees the same frames in the same order as beside the steps.

use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::{FieldCopy, Frame, FrameCopy, Outcome, Recorder, RecorderError};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::Builder;

/// Copies that go round: how many steps the run may be ahead of its recorder.
const COPIES: usize = 16;
/// Memory for fields that goes round, each as large as the state: how many field times the run may be ahead.
const FIELDS: usize = 2;

/// What the thread is asked for.
enum Order {
    Start,
    Record(Box<FrameCopy>),
    Finish(Box<Outcome>),
}

/// What it answers to each order; the copy comes back.
struct Done {
    result: Result<(), RecorderError>,
    copy: Option<Box<FrameCopy>>,
}

/// Calls `run` with a recorder that hands everything on to `recorder` on a thread of its own, which ends with the call.
///
/// What `recorder` cannot record is told with one of the next frames, or at the end.
///
/// # Panics
/// With the panic of `recorder`, if it did.
pub fn on_own_thread<T>(
    plan: &Plan,
    recorder: &mut (dyn Recorder + Send),
    run: impl FnOnce(&mut dyn Recorder) -> T,
) -> T {
    std::thread::scope(|scope| {
        let (orders, received) = sync_channel(COPIES);
        // Room for every answer, so that the thread never waits for the run: only the run waits, for a copy.
        let (answers, done) = sync_channel(COPIES + 1);
        let thread = Builder::new()
            .name("recorder".into())
            .spawn_scoped(scope, move || serve(plan, recorder, &received, &answers));
        let mut handle = Handle {
            orders,
            done,
            copies: (0..COPIES).map(|_| Box::new(FrameCopy::new(plan))).collect(),
            fields: (0..FIELDS).map(|_| Box::new(FieldCopy::new(plan))).collect(),
        };
        let result = run(&mut handle);
        drop(handle);
        // A thread that the system did not give has dropped its ends of the channels: the run has failed for that.
        if let Ok(Err(panic)) = thread.map(std::thread::ScopedJoinHandle::join) {
            std::panic::resume_unwind(panic);
        }
        result
    })
}

/// The thread: does what it is asked for until the handle is dropped. After a failure frames are taken and left.
fn serve(plan: &Plan, recorder: &mut dyn Recorder, orders: &Receiver<Order>, answers: &SyncSender<Done>) {
    let (mut u, mut has_failed) = (vec![Vec3::zeros(); plan.node_count()], false);
    for order in orders {
        let (result, copy) = match order {
            Order::Start => (recorder.start(plan), None),
            Order::Record(copy) if has_failed => (Ok(()), Some(copy)),
            Order::Record(mut copy) => (recorder.record(&copy.frame(plan, &mut u)), Some(copy)),
            Order::Finish(outcome) => (recorder.finish(plan, &outcome), None),
        };
        has_failed |= result.is_err();
        if answers.send(Done { result, copy }).is_err() {
            return;
        }
    }
}

/// The recorder that the run sees.
#[allow(clippy::vec_box)] // they travel through the queues as they are
struct Handle {
    orders: SyncSender<Order>,
    done: Receiver<Done>,
    /// Copies that are not on their way.
    copies: Vec<Box<FrameCopy>>,
    fields: Vec<Box<FieldCopy>>,
}

impl Handle {
    fn order(&self, order: Order) -> Result<(), RecorderError> {
        self.orders.send(order).map_err(|_| gone())
    }

    /// Waits until everything ordered so far is done; the first failure of it.
    fn wait_for_all(&mut self) -> Result<(), RecorderError> {
        let mut result = Ok(());
        loop {
            let done = self.done.recv().map_err(|_| gone())?;
            let is_last = done.copy.is_none();
            let found = self.take_back(done);
            result = result.and(found);
            if is_last {
                return result;
            }
        }
    }

    fn take_back(&mut self, done: Done) -> Result<(), RecorderError> {
        if let Some(mut copy) = done.copy {
            self.fields.extend(copy.take_field());
            self.copies.push(copy);
        }
        done.result
    }

    /// A copy to fill, with memory for the fields if asked for; waits for one if all are on their way.
    #[allow(clippy::type_complexity)] // a pair of what the caller asked for
    fn free_copy(
        &mut self,
        with_field: bool,
    ) -> Result<(Box<FrameCopy>, Option<Box<FieldCopy>>), RecorderError> {
        while let Ok(done) = self.done.try_recv() {
            self.take_back(done)?;
        }
        loop {
            if !(self.copies.is_empty() || with_field && self.fields.is_empty())
                && let Some(copy) = self.copies.pop()
            {
                return Ok((copy, if with_field { self.fields.pop() } else { None }));
            }
            let done = self.done.recv().map_err(|_| gone())?;
            self.take_back(done)?;
        }
    }
}

/// The thread has ended before its time; the panic that ended it is passed on when the run has ended.
fn gone() -> RecorderError {
    RecorderError("the thread of the recording is not there".into())
}

impl Recorder for Handle {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        self.order(Order::Start)?;
        self.wait_for_all()
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let (mut copy, field) = self.free_copy(frame.is_look_time)?;
        copy.take(frame, field);
        self.order(Order::Record(copy))
    }

    fn finish(&mut self, _: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        self.order(Order::Finish(Box::new(outcome.clone())))?;
        self.wait_for_all()
    }
}
